"""Beside an edge, where lag and play are there before any way is made, a body makes itself room."""

from __future__ import annotations

import pytest

from agents.bodies.inertial import InertialBody, _cut
from agents.lines.boundary import RoundBoundary
from agents.lines.line import HalfPlane
from protocol.bodies.base import Base, Motion, chord, turned
from protocol.bodies.sweep import Miss, Sweep
from protocol.messages import BaseMotion
from protocol.scenario.body import PRESETS

PERIOD, SPEED = 0.05, 0.1
WHEELED = [name for name in PRESETS if name != "point"]
FACING = [0.1 * n for n in range(63)]
ROOM = RoundBoundary(10.0)


class Track:
    """A body that drives beside the edge x = 0 of the half-plane x < 0, and begins some berths off it."""

    def __init__(self, name: str, berths: float, heading: float) -> None:
        preset = PRESETS[name]
        self.base = Base(preset, PERIOD)
        self.body = InertialBody(self.base, SPEED, Miss(preset.error, preset.lag, preset.play))
        self.x, self.y = -berths * self.body.berth, 0.0
        self.motion = Motion(heading)

    def tick(self, desired: tuple[float, float]) -> tuple[float, float]:
        """Go through a tick; what is commanded."""
        arc = self.base.halt(self.motion)
        stop = turned(*chord(arc, self.base.turn(arc)), self.motion.heading)
        self.body.on_motion(BaseMotion(self.motion.velocity, self.motion.heading, stop))
        edge = HalfPlane(1.0, 0.0, 0.0)
        command = self.body.velocity(desired, (self.x, self.y), [edge], ROOM, None)
        ahead, aside = self.base.limited(self.motion, command)
        heading = self.motion.heading
        for arc in self.base.drive(self.motion, ahead, aside):
            dx, dy = turned(*chord(arc, self.base.turn(arc)), heading)
            self.x, self.y = self.x + dx, self.y + dy
            heading += self.base.turn(arc)
        self.motion = self.base.driven(self.motion, ahead, aside)
        return command


@pytest.mark.parametrize("name", WHEELED)
def test_a_body_leaves_an_edge_from_its_berth_whichever_way_it_faces(name):
    for heading in FACING:
        track = Track(name, 1.01, heading)
        track.tick((-SPEED, 0.0))
        assert track.x < -1.01 * track.body.berth, heading


@pytest.mark.parametrize("name", WHEELED)
def test_and_nearer_than_half_of_it_some_way_of_facing_holds_it(name):
    """The berth is no larger than it has to be."""
    held = 0
    for heading in FACING:
        track = Track(name, 0.5, heading)
        held += track.tick((-SPEED, 0.0)) == (0.0, 0.0)
    assert held > 0


@pytest.mark.parametrize("name", WHEELED)
def test_who_is_too_near_an_edge_to_drive_along_it_makes_itself_room(name):
    for heading in FACING[::6]:
        track = Track(name, 1.1, heading)
        for _ in range(60):
            track.tick((0.0, SPEED))
        assert track.y > 0.5 * 60 * PERIOD * SPEED, heading


def test_a_body_that_comes_back_to_where_it_began_may_still_miss_that_place():
    back = Sweep([0.0], [0.0], [0.002])
    assert _cut(ROOM, ROOM.radius - 0.001, 0.0, None, back) is not None
    assert _cut(ROOM, ROOM.radius - 0.003, 0.0, None, back) is None
