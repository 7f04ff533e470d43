"""Beside an edge, where lag and play are there before any way is made, a body makes itself room."""

from types import SimpleNamespace

import pytest

from agents.bodies import InertialBody
from agents.lines.boundary import RoundBoundary
from agents.lines.safe_velocity import Limits
from protocol.bodies.kinematics import Kinematics, Motion
from protocol.bodies.sweep import Sweep, Tolerance
from protocol.line import HalfPlane
from protocol.messages import STILL, BaseMotion
from protocol.scenario.body import PRESETS, Body
from world.plants.integrator import SimulatedBase

PERIOD, SPEED = 0.05, 0.1
WHEELED = [name for name in PRESETS if name != "point"]
FACING = [0.3 * n for n in range(21)]
ROOM = RoundBoundary(10.0)


EXACT = SimpleNamespace(at=lambda _: STILL)  # errors of a base that has none


class Track:
    """A body that drives beside the edge x = 0 of the half-plane x < 0, and begins some standoffs off it."""

    def __init__(self, name: str, standoffs: float, heading: float) -> None:
        kinematics, tolerance = Kinematics(PRESETS[name], PERIOD), Tolerance(PRESETS[name])
        self.body = InertialBody(kinematics, SPEED, tolerance)
        self.base = SimulatedBase(kinematics, tolerance, Motion(heading), EXACT)
        self.x, self.y = -standoffs * self.body.standoff, 0.0

    def tick(self, desired: tuple[float, float]) -> tuple[float, float]:
        """Go through a tick; what is commanded."""
        motion = self.base.motion
        self.body.on_motion(BaseMotion(motion.velocity, motion.heading, self.base.report((0.0, 0.0)).stop))
        edge = HalfPlane(1.0, 0.0, 0.0)
        command = self.body.velocity(desired, Limits((self.x, self.y), [edge], [ROOM], None))
        for dx, dy in self.base.move(command, 0):
            self.x, self.y = self.x + dx, self.y + dy
        return command


@pytest.mark.slow
@pytest.mark.parametrize("name", WHEELED)
def test_a_body_leaves_an_edge_from_its_standoff_whichever_way_it_faces(name):
    for heading in FACING:
        track = Track(name, 1.01, heading)
        track.tick((-SPEED, 0.0))
        assert track.x < -1.01 * track.body.standoff, heading


@pytest.mark.slow
@pytest.mark.parametrize("name", WHEELED)
def test_a_robot_that_is_too_near_an_edge_to_drive_along_it_makes_itself_room(name):
    for heading in FACING[::3]:
        track = Track(name, 1.1, heading)
        for _ in range(60):
            track.tick((0.0, SPEED))
        assert track.y > 0.5 * 60 * PERIOD * SPEED, heading


def test_a_body_that_comes_back_to_where_it_began_may_still_miss_that_place():
    back = Sweep([0.0, 0.0], [0.0, 0.0], [0.0, 0.002])
    assert Limits((ROOM.radius - 0.001, 0.0), [], [ROOM], None).cut(back) is not None
    assert Limits((ROOM.radius - 0.003, 0.0), [], [ROOM], None).cut(back) is None


def test_no_body_reaches_farther_than_its_wheels_or_the_room_allow():
    """However large the speed limit is, which a robot keeps to only as far as its base can."""
    burger = PRESETS["turtlebot3-burger"]
    body = InertialBody(Kinematics(burger, PERIOD), 1e6, Tolerance(burger))
    assert body.reach < 0.22 * (PERIOD + burger.hold + 0.5 * 0.22 / burger.acceleration) * 1.1 + 0.01
    fast = Body("omnidirectional", speed=1e6, acceleration=0.1)
    body = InertialBody(Kinematics(fast, PERIOD), 1e6, Tolerance(fast), longest=4.0)
    assert body.reach == 4.0
