"""Robots' nodes with external bases, on the in-process bus; what they would wait for is skipped."""

import math
import random
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from agents.bases import base as choice
from agents.bases.base import topics_of
from agents.bases.ros_messages import Flag, Velocity
from deploy.library.load import load
from protocol.bus.bus import Event, Presence, RawSample, Sample
from protocol.codec import encode
from protocol.errors import BusError, JoinError, UsageError
from protocol.keys import driver_token, robot_key
from protocol.messages import Tick
from protocol.scenario.places import room_at_start
from tests.agents.bases.test_senses import fleet
from tests.agents.bases.wheels import STEP, Wheels
from tests.mortal import MortalFleet
from tests.skipped_waits import skipped_waits
from world.report import result_of
from world.world import WorldCore


@pytest.fixture(autouse=True)
def _skipped_waits(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Time of the base is that of its robot: no computer is suspended."""
    with skipped_waits():
        monkeypatch.setattr(time, "clock_gettime", lambda _: time.monotonic())
        yield


class Floor:
    """The wheels of all robots, as one participant of the bus."""

    def __init__(self, bus, scenario) -> None:
        self.deadline, self.finished = 0.0, False
        self.closest = math.inf  # m, smallest distance of two so far
        self.wheels = {robot: Wheels(scenario, robot, random.Random(robot)) for robot in scenario.ids}
        self._bus, self._began, self._steps = bus, time.monotonic(), 0
        self._tell = {
            (robot, what): bus.raw_publisher(f"bot{robot}/{what}")
            for robot in self.wheels
            for what in ("odom", "pose")
        }
        for robot in self.wheels:
            bus.listen(f"bot{robot}/cmd_vel")

    def handle(self, event: Event) -> None:
        if isinstance(event, RawSample):
            self.wheels[int(event.key[3])].on_message(event.payload, self._steps * STEP)

    def on_timer(self, now: float) -> None:
        while self._steps * STEP <= now - self._began:
            self._steps += 1
            one, other = self.wheels.values()
            self.closest = min(self.closest, math.dist(one.control, other.control))
            for robot, each in self.wheels.items():
                each.roll(self._steps * STEP)
                if self._steps % 4 == 0:
                    self._tell[robot, "odom"](each.odometry(self._steps * STEP).serialize())
                if self._steps % 8 == 0:
                    self._tell[robot, "pose"](each.pose(self._steps * STEP).serialize())
        self.deadline = now + 0.01


class Stage:
    """A world, two robots and their floor."""

    def __init__(self, caplog, checkpoint: Path | None = None, *settings: str) -> None:
        self.scenario = fleet(2, "time.endless=true", "base.tools=true", *settings)
        self.fleet, self._log = MortalFleet(self.scenario, checkpoint), caplog
        bus = self.fleet.network.connect()
        self.floor = bus.node = Floor(bus, self.scenario)

    @property
    def world(self) -> WorldCore:
        return self.fleet.world.world

    def said(self, robot: int) -> list[str]:
        texts = (record.message.partition(": ") for record in self._log.records)
        return [text for name, _, text in texts if name == f"robot-{robot}"]

    def play(self, until) -> None:
        end = time.monotonic() + 90.0
        self.fleet.network.run(lambda: until() or time.monotonic() > end)
        assert until()

    def away(self, robot: int) -> float:
        return math.dist(self.floor.wheels[robot].control, self.scenario.spec(robot).start)


@pytest.mark.slow
def test_robots_join_once_they_know_where_they_are_and_drive(caplog):
    stage = Stage(caplog)
    assert stage.world.tick == 0
    stage.play(lambda: min(map(stage.away, (1, 2))) > 0.03)
    for robot in (1, 2):
        assert stage.said(robot) == [
            "waits for odometry and a pose; stands",
            "base and localisation work again",
        ]
    reported = stage.world.simulation.places
    for robot, place in reported.items():
        assert math.dist(place, stage.floor.wheels[robot].control) < 0.06

    core = stage.fleet.robots[2].node.core
    over = Tick(2, core.incarnation, core.tick, (), epoch=core.epoch, over=True)
    stop = RawSample("bot1/disknav/stop", Flag(True).serialize())
    for robot, event in (1, stop), (2, Sample(robot_key("local", 2, "tick"), encode(over))):
        heard = stage.fleet.network.connect()
        heard.listen(f"bot{robot}/cmd_vel")
        stage.fleet.robots[robot].node.handle(event)
        assert heard.receive(0.0) is not None, "it brakes at once, not with the next Tick"
    stage.play(lambda: stage.floor.wheels[1].aims == (0.0, 0.0))
    stage.fleet.robots[1].node.handle(Presence(driver_token("0/bot1/cmd_vel", "another"), True))
    stage.play(lambda: stage.said(1)[-1].startswith("another process drives bot1/cmd_vel"))


@pytest.mark.slow
def test_a_robot_drives_as_a_planner_wishes_while_it_does(caplog):
    stage = Stage(caplog, None, "control.law=external")
    node, wheels = stage.fleet.robots[1].node, stage.floor.wheels[1]
    stage.play(lambda: len(stage.said(1)) == 2 and stage.world.tick > 2)
    assert wheels.aims == (0.0, 0.0)
    node.handle(RawSample("bot1/cmd_vel_desired", Velocity([0.1, 0.0, 0.0], [0.0] * 3).serialize()))
    stage.play(lambda: stage.away(1) > 0.01)
    stage.play(lambda: wheels.aims == (0.0, 0.0))


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [0.0, 3.0], ids=["while they drive", "once they stand"])
def test_another_world_takes_over_bases_that_drive(seconds: float, tmp_path: Path, caplog) -> None:
    """They face each other, and move on although the places in which they may be overlapped."""
    stage = Stage(caplog, tmp_path / "checkpoint")
    stage.play(lambda: min(map(stage.away, (1, 2))) > 0.1)
    stage.fleet.kill_world()
    tick, end = stage.world.tick, time.monotonic() + seconds
    epoch = stage.fleet.robots[1].node.core.epoch
    stage.play(lambda: time.monotonic() >= end)
    stage.fleet.start_world()
    begun, node, heard = stage.world, stage.fleet.robots[1].node, stage.fleet.network.connect()
    heard.listen("bot1/cmd_vel")
    assert (begun.tick, begun.lives.up) == (tick, ())
    node._join()
    assert node.core.epoch != epoch
    assert heard.receive(0.0) is not None, "it brakes as it is admitted, not with its first Tick"
    stage.play(lambda: len(begun.lives.up) == 2)
    before = [wheels.control for wheels in stage.floor.wheels.values()]
    stage.play(
        lambda: all(
            math.dist(wheels.control, place) > 0.1
            for wheels, place in zip(stage.floor.wheels.values(), before, strict=True)
        )
    )
    assert stage.floor.closest > sum(spec.radius for spec in stage.scenario.robots)
    assert result_of(begun)["collisions"] == 0
    assert result_of(begun)["worlds"] == [tick]


@pytest.mark.slow
def test_robots_that_have_left_their_starts_do_not_begin_another_run(caplog) -> None:
    stage = Stage(caplog)
    stage.play(lambda: min(map(stage.away, (1, 2))) > 0.1)
    stage.fleet.kill_world()
    stage.fleet.start_world()
    with pytest.raises(BusError, match="another run has the name"):
        stage.play(lambda: stage.world.lives.founded)
    assert not any(life.joined for life in stage.world.lives.of.values())


@pytest.mark.slow
def test_a_robot_that_does_not_stand_at_its_start_keeps_the_run_from_beginning(caplog):
    stage = Stage(caplog)
    stage.floor.wheels[2].x += 0.5
    stage.play(lambda: len(stage.said(2)) == 2)
    assert "from its start" in stage.said(2)[1]
    assert "because of" in stage.said(2)[1]
    assert stage.world.tick == 0
    stage.floor.wheels[2].x -= 0.5  # it is carried there: odometry does not see that, poses do
    stage.play(lambda: stage.world.tick > 2)
    assert stage.said(2)[-1] == "base and localisation work again"


@pytest.mark.parametrize("bound", [0.0, 0.01])
@pytest.mark.parametrize("more", [-1e-6, 1e-6])
def test_a_robot_begins_only_where_it_is_surely_apart_from_the_places_of_all_others(bound, more) -> None:
    scenario = load("turtlebots-2")
    (x, y), (room, what) = scenario.spec(2).start, room_at_start(scenario, 2)
    off = 0.99 * room - bound + more
    text = choice.misplaced(scenario, 2, (x + 0.6 * off, y - 0.8 * off), bound)
    said = f"stands {off:.3g} m from its start ({x:g}, {y:g}), known to {bound:.2g} m; put it within "
    assert text == ("" if more < 0.0 else f"{said}{0.99 * room - bound:.2g} m, because of {what}")


def test_a_robot_has_topics_if_it_has_a_base_or_tools_and_what_they_need_is_installed(monkeypatch) -> None:
    simulated, tools = load("turtlebots-2", ["base.domain=3"]), load("turtlebots-2", ["base.tools=true"])
    outside = load("turtlebots-2", ["world.plant=external"])
    assert simulated.base_of(1) is not None is topics_of(simulated, 1)
    assert topics_of(tools, 1) == tools.base_of(1).of(1)
    assert topics_of(outside, 1) == topics_of(outside, 1, "") == outside.base_of(1).of(1)
    assert topics_of(outside, 1, "/other").namespace == "/other"
    with pytest.raises(JoinError, match=r'set world\.plant = "external"'):
        topics_of(simulated, 1, "/bot1")
    monkeypatch.setattr(choice, "find_spec", lambda _: None)
    with pytest.raises(UsageError, match=r'pip install "disknav\[ros2\]"'):
        topics_of(outside, 1)
