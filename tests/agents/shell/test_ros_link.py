"""A simulated fleet that serves tools of ROS, on the in-process bus, in both dialects."""

import math
import time

import pytest

from agents.bases import dialects as ros
from agents.bases.dialects import Topic, dialect_of
from agents.bases.ros_messages import Flag, Header, Markers, Odometry, Pose, StampedPose, Transforms, decode
from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import RawSample

SETTINGS = ("base.tools=true", "time.endless=true", "body=point")


class Person:
    """Hears and says what RViz would, of robot 1."""

    def __init__(self, bus, base) -> None:
        self.deadline, self.finished = math.inf, False
        self.dialect, self.heard, self._bus = dialect_of(base), {}, bus
        for name, kind in (("/tf", ros.TF), ("disknav/odom", ros.ODOMETRY), ("disknav/markers", ros.MARKERS)):
            bus.listen(self.dialect.expression(Topic(base.topic(name), kind)))
        stop = Topic(base.topic("disknav/stop"), ros.BOOL)
        goal = Topic(base.topic("goal_pose"), ros.STAMPED_POSE)
        self.stop, self.goal = (
            bus.raw_publisher(self.dialect.key(each), self.dialect.attach(each.name)) for each in (stop, goal)
        )
        self.bad_stop = bus.raw_publisher(self.dialect.key(stop), lambda: b"short")

    def handle(self, event) -> None:
        if isinstance(event, RawSample):
            self.heard[self.dialect.name(event.key)] = event

    def go(self, x: float, y: float, frame: str = "map") -> None:
        self.goal(StampedPose(Header(0, 0, frame), Pose([x, y, 0.0], [0.0, 0.0, 0.0, 1.0])).serialize())


class Stage:
    def __init__(self, *settings: str) -> None:
        scenario = load("turtlebots-2", [*SETTINGS, *settings], 1)
        self.fleet = LocalFleet(scenario)
        bus = self.fleet.network.connect()
        self.person = bus.node = Person(bus, scenario.base_of(1).of(1))

    def play(self, until) -> None:
        end = time.monotonic() + 60.0
        self.fleet.network.run(lambda: until() or time.monotonic() > end)
        assert until()

    def ticks(self, count: int) -> None:
        last = self.fleet.world.world.tick + count
        self.play(lambda: self.fleet.world.world.tick >= last)

    @property
    def place(self):
        return self.fleet.world.world.simulation.places[1]


@pytest.mark.parametrize("dialect", ["ros2dds", "rmw_zenoh"])
def test_people_see_a_robot_stop_it_and_send_it(dialect, caplog):
    stage = Stage(f"base.dialect={dialect}")
    person, tf = stage.person, "tf" if dialect == "rmw_zenoh" else "bot1/tf"
    stage.play(lambda: person.heard.keys() >= {tf, "bot1/disknav/odom", "bot1/disknav/markers"})
    (moved,) = decode(Transforms, person.heard[tf].payload).transforms
    assert moved.header.frame == "map"
    assert moved.child in ("bot1/disk", "bot2/disk")
    odometry = decode(Odometry, person.heard["bot1/disknav/odom"].payload)
    assert math.dist(odometry.pose.position[:2], stage.place) < 0.3
    drawn = decode(Markers, person.heard["bot1/disknav/markers"].payload).markers
    assert {marker.namespace: marker.type for marker in drawn[:2]} == {"disk": 3, "goal": 2}
    assert drawn[0].scale[0] == pytest.approx(0.3)

    person.stop(Flag(True).serialize())
    stage.ticks(2)
    place = stage.place
    stage.ticks(10)
    assert stage.place == place
    person.stop(Flag(False).serialize())
    stage.play(lambda: math.dist(stage.place, place) > 0.01)

    person.go(0.5, 0.6)
    stage.play(lambda: stage.fleet.robots[1].node.core.goal == (0.5, 0.6))
    assert caplog.messages == [f"robot-1: bot1/disknav/stop says {what}" for what in ("stop; stands", "go")]
    person.go(50.0, 0.0)
    stage.play(lambda: any("a goal is refused" in text for text in caplog.messages))


def test_what_is_no_message_is_ignored_counted_and_said_once(caplog):
    stage = Stage("base.dialect=rmw_zenoh", "sensing.delay=0.2")  # at first it does not know its place
    robot, person = stage.fleet.robots[1].node, stage.person
    stage.play(lambda: "tf" in person.heard)
    goal = robot.core.goal
    for _ in range(3):
        person.bad_stop(Flag(True).serialize())
        person.stop(b"\0\1\0\0" + bytes(9))
        person.go(0.1, 0.1, frame="odom")
        person.go(math.nan, 0.0)
    stage.play(lambda: robot._health().rejected == {"shape": 6, "range": 6})
    assert len(caplog.messages) == 2
    assert "an attachment of 5 bytes" in caplog.messages[0]
    assert "a goal in 'odom', not in 'map'" in caplog.messages[1]
    assert not robot.core.stopped
    assert robot.core.goal == goal
