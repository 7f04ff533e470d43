"""Planners of ROS 2 drive straight at their goals, through each other; the filter keeps them apart."""

import math

import pytest

from agents.bases.ros2 import Ros2Base
from agents.bases.ros_messages import StampedVelocity, Velocity, header_at
from protocol.errors import MessageError
from protocol.scenario.model import Scenario
from tests.agents.bases.crossing import CROSSING
from tests.agents.bases.floor import Floor
from tests.agents.bases.test_senses import fleet
from world.report import result_of

SPEED = 0.12  # m/s


def crossing(*settings: str) -> Scenario:
    return fleet(3, *CROSSING, "time.limit=90", "control.law=external", *settings)


def straight(floor: Floor, robot: int) -> bytes:
    """Straight on to the goal: the Twist of a differential drive's control point."""
    crew, spec = floor.crews[robot], floor.scenario.spec(robot)
    x, y = crew.wheels.control
    dx, dy = spec.goal[0] - x, spec.goal[1] - y
    scale = min(SPEED / max(math.hypot(dx, dy), 1e-9), 1.0)
    heading, offset = crew.wheels.yaw, floor.scenario.body_of(robot).offset
    ahead = scale * (math.cos(heading) * dx + math.sin(heading) * dy)
    aside = scale * (math.cos(heading) * dy - math.sin(heading) * dx)
    twist = Velocity([ahead, 0.0, 0.0], [0.0, 0.0, aside / offset])
    return twist.serialize()


class Planned(Floor):
    """Every robot has a planner that publishes ten times a second."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario, 3)
        self._later(0.0, self._plan)

    def _plan(self) -> None:
        for robot, crew in self.crews.items():
            wish = crew.base.on_message(crew.base.topics[2], straight(self, robot), self.now)
            if wish is not None:
                crew.core.on_wish(wish)
        self._later(0.1, self._plan)


@pytest.mark.slow
def test_planners_that_heed_no_robot_arrive_behind_the_filter() -> None:
    floor = Planned(crossing()).run(90.0)
    assert result_of(floor.world)["verdict"] == "arrived"
    assert floor.closest > 0.0


@pytest.mark.slow
def test_without_the_filter_they_collide() -> None:
    assert Planned(crossing("control.filter=none")).run(90.0).closest < 0.0


@pytest.mark.parametrize("bad", [math.nan, math.inf, 1e300])
def test_a_velocity_that_is_no_number_is_refused(bad: float) -> None:
    scenario = crossing()
    base = Ros2Base(scenario, 1, scenario.base_of(1))
    for linear, angular in (([bad, 0.0, 0.0], [0.0] * 3), ([0.0] * 3, [0.0, 0.0, bad])):
        with pytest.raises(MessageError):
            base.on_message(base.topics[2], Velocity(linear, angular).serialize(), 0.0)
    with pytest.raises(MessageError):
        base.on_message(base.topics[2], b"what", 0.0)


def test_a_stamped_base_takes_stamped_wishes() -> None:
    scenario = crossing("base.stamped=true")
    base, twist = Ros2Base(scenario, 1, scenario.base_of(1)), Velocity([0.1, 0.0, 0.0], [0.0] * 3)
    stamped = StampedVelocity(header_at(0, "base"), twist)
    assert base.on_message(base.topics[2], stamped.serialize(), 0.0) is None  # the heading is unknown
    with pytest.raises(MessageError):
        base.on_message(base.topics[2], twist.serialize(), 0.0)


def test_only_the_law_from_outside_subscribes_to_wishes() -> None:
    scenario = crossing("control.law=reciprocal")
    names = [topic.name for topic in Ros2Base(scenario, 1, scenario.base_of(1)).topics]
    assert names == ["bot1/odom", "bot1/pose"]
