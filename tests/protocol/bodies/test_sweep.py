"""Everything that a body may do, as the plant does it at its worst, lies in its sweep."""

import math
from dataclasses import replace
from types import SimpleNamespace

from hypothesis import given
from hypothesis import strategies as st

from protocol.bodies.kinematics import Arc, Kinematics, Motion, chord
from protocol.bodies.sweep import Sweep, Tolerance, sweep
from protocol.scenario.body import PRESETS, Body
from world.plants.integrator import SimulatedBase

PERIODS = st.sampled_from([0.01, 0.05, 0.2, 1.0])
ERRORS = {"error": 0.1, "lag": 0.015, "play": 3e-4}
BURGER = replace(PRESETS["turtlebot3-burger"], hold=0.12)
WHEELLESS = Body("omnidirectional", acceleration=0.5, hold=0.12, **ERRORS)
BRISK = Body("omnidirectional", acceleration=50.0, lag=0.05, play=1e-3)
POINT = Body("point", **ERRORS)
SPINNING = Body("differential-drive", 0.1, 0.02, 0.05, 1.0, 0.5, 20.0, **ERRORS)  # circles until it stands
bodies = st.sampled_from([BURGER, WHEELLESS, BRISK, POINT, SPINNING])
speeds = st.integers(-150_000, 150_000).map(lambda number: number * 1e-6)  # in um/s: none is next to nothing
angles = st.floats(-math.pi, math.pi)
ROUNDING = 1e-14  # m


def drawn(body: Body, period: float, heading: float, ahead: float, aside: float) -> tuple[Kinematics, Motion]:
    """What a body does; a point stands as a tick begins."""
    motion = Motion(heading) if body.kind == "point" else Motion(heading, ahead, aside, 0.5 * body.hold)
    return Kinematics(body, period), motion


@given(bodies, PERIODS, angles, speeds, speeds, speeds, speeds, angles, angles, st.integers(0, 3))
def test_the_plant_keeps_to_it_however_large_its_errors_are(
    body, period, heading, ahead, aside, vx, vy, off, towards, heard
):
    """From the first part of the tick on, and over those in which it hears nothing, or is told to brake."""
    kinematics, motion = drawn(body, period, heading, ahead, aside)
    tolerance = Tolerance(body)
    errors = SimpleNamespace(at=lambda _: (math.cos(off), math.sin(off)))  # always the same
    base = SimulatedBase(kinematics, tolerance, motion, errors)
    passed = sweep(kinematics, motion, tolerance, kinematics.limited(motion, (vx, vy)))
    nx, ny = math.cos(towards), math.sin(towards)
    x = y = 0.0
    for tick in range(4):
        command = None if tick < heard else (0.0, 0.0)
        for dx, dy in base.move((vx, vy) if tick == 0 else command, tick):
            x, y = x + dx, y + dy
            if (vx, vy) != (0.0, 0.0):
                assert nx * x + ny * y <= passed.extent(nx, ny) + ROUNDING
                assert math.hypot(x, y) <= passed.radius + ROUNDING
                assert math.hypot(x - passed.middle[0], y - passed.middle[1]) <= passed.spread + ROUNDING


@given(bodies, PERIODS, angles, speeds, speeds, speeds, speeds, angles)
def test_it_contains_the_arcs_and_is_not_much_larger(body, period, heading, ahead, aside, vx, vy, towards):
    kinematics, motion = drawn(body, period, heading, ahead, aside)
    to = kinematics.limited(motion, (vx, vy))
    tolerance = Tolerance(body)
    passed, slip = sweep(kinematics, motion, tolerance, to), tolerance.slip(motion, to)
    nx, ny = math.cos(towards), math.sin(towards)
    x = y = farthest = way = 0.0
    heading = motion.heading
    for arc in [*kinematics.drive(motion, *to), kinematics.halt(kinematics.driven(motion, *to))]:
        parts = 8 + 8 * int(abs(kinematics.turn(arc)))
        part = Arc(arc.ahead, arc.aside, arc.duration / parts)
        turn = kinematics.turn(part)
        for _ in range(parts):
            way += math.hypot(part.ahead, part.aside) * part.duration
            dx, dy = chord(part, turn, heading)
            x, y, heading = x + dx, y + dy, heading + turn
            farthest = max(farthest, nx * x + ny * y)
            margin = tolerance.error * way + slip
            assert nx * x + ny * y + margin <= passed.extent(nx, ny) + ROUNDING
    assert passed.extent(nx, ny) <= farthest + (0.25 + tolerance.error) * way + slip + ROUNDING


def test_a_body_that_comes_back_to_where_it_began_still_has_a_sweep():
    passed = Sweep([0.0, 0.0], [0.0, 0.0], [0.001, 0.002])
    assert (passed.radius, passed.spread, passed.extent(0.0, 1.0)) == (0.002, 0.002, 0.002)
