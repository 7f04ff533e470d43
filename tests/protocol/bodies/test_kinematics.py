"""Kinematics against wheels that are integrated in small steps, by other formulas."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.bodies.kinematics import Arc, Kinematics, Motion, chord, steps_of, turned
from protocol.scenario.body import PRESETS, Body

BURGER = replace(PRESETS["turtlebot3-burger"], hold=0.12)
WHEELLESS = Body("omnidirectional", acceleration=0.5, hold=0.12)
PERIOD = 0.05
FINE = 2000  # steps of the other integration
speeds = st.integers(-150_000, 150_000).map(lambda number: number * 1e-6)  # in um/s: none is next to nothing
angles = st.floats(-math.pi, math.pi)
Vector = tuple[float, float]


def wheels(body: Body, ahead: float, aside: float) -> Vector:
    """Rim speeds left and right of a control point's velocity."""
    rate = aside / body.offset
    return ahead - 0.5 * rate * body.track, ahead + 0.5 * rate * body.track


def rolled(body: Body, heading: float, profile: list[Vector], duration: float) -> tuple[Vector, float]:
    """Displacement of the control point and heading after wheels have had these speeds, evenly in time."""
    x, y = body.offset * math.cos(heading), body.offset * math.sin(heading)
    start = x, y
    cx = cy = 0.0
    step = duration / len(profile)
    for left, right in profile:
        speed, rate = 0.5 * (left + right), (right - left) / body.track
        middle = heading + 0.5 * rate * step
        cx, cy = cx + speed * math.cos(middle) * step, cy + speed * math.sin(middle) * step
        heading += rate * step
    x, y = cx + body.offset * math.cos(heading), cy + body.offset * math.sin(heading)
    return (x - start[0], y - start[1]), heading


def along(base: Kinematics, motion: Motion, arcs: list[Arc]) -> tuple[Vector, float]:
    """The same of arcs."""
    x = y = 0.0
    heading = motion.heading
    for arc in arcs:
        turn = base.turn(arc)
        dx, dy = chord(arc, turn, heading)
        x, y, heading = x + dx, y + dy, heading + turn
    return (x, y), heading


@given(angles, speeds, speeds, st.floats(0.0, 0.12), st.floats(0.0, 0.6))
@settings(max_examples=40, deadline=None)
def test_coasting_holds_and_then_brakes_both_wheels_by_one_factor(heading, ahead, aside, hold, duration):
    base, motion = Kinematics(BURGER, PERIOD), Motion(heading, ahead, aside, hold)
    left, right = wheels(BURGER, ahead, aside)
    fastest = max(abs(left), abs(right))
    profile = []
    for step in range(FINE):
        braked = max(0.0, (step + 0.5) / FINE * duration - hold) * BURGER.acceleration
        share = max(0.0, 1.0 - braked / fastest) if fastest > 0.0 else 0.0
        profile.append((left * share, right * share))
    expected, faces = rolled(BURGER, heading, profile, duration)
    found, turned_to = along(base, motion, [base.coast(motion, duration)])
    assert found == pytest.approx(expected, abs=1e-6)
    assert turned_to == pytest.approx(faces, abs=1e-5)
    after = base.coasted(motion, duration)
    assert after.heading == pytest.approx(turned_to)
    later = wheels(BURGER, after.ahead, after.aside)
    assert later == pytest.approx(profile[-1], abs=1e-3)


@given(angles, speeds, speeds, speeds, speeds)
def test_a_command_ends_in_what_it_asks_for_within_what_wheels_can_do(heading, ahead, aside, vx, vy):
    base, motion = Kinematics(BURGER, PERIOD), Motion(heading, ahead, aside, 0.0)
    to = base.limited(motion, (vx, vy))
    changes = [b - a for a, b in zip(wheels(BURGER, ahead, aside), wheels(BURGER, *to), strict=True)]
    assert max(map(abs, changes)) <= BURGER.acceleration * PERIOD * (1.0 + 1e-9)
    asked = turned(vx, vy, -heading)
    if max(abs(each) for each in wheels(BURGER, *asked)) <= BURGER.speed:
        more = (asked[0] - ahead, asked[1] - aside)
        got = (to[0] - ahead, to[1] - aside)
        assert more[0] * got[1] - more[1] * got[0] == pytest.approx(0.0, abs=1e-12)  # on the way there
    arcs = base.drive(motion, *to)
    expected, faces = rolled(
        BURGER, heading, [wheels(BURGER, a.ahead, a.aside) for a in arcs for _ in range(200)], PERIOD
    )
    found, turned_to = along(base, motion, arcs)
    assert len(arcs) == base.steps == steps_of(PERIOD)
    assert found == pytest.approx(expected, abs=1e-6)
    assert turned_to == pytest.approx(faces)
    assert base.driven(motion, *to).heading == pytest.approx(turned_to)


@given(angles, speeds, speeds, st.floats(0.0, 0.12), st.sampled_from([BURGER, WHEELLESS]))
def test_velocity_direction_and_place_to_stand_say_all_of_a_motion(heading, ahead, aside, hold, body):
    base, motion = Kinematics(body, PERIOD), Motion(heading, ahead, aside, hold)
    stop, _ = along(base, motion, [base.halt(motion)])
    again = base.motion(motion.velocity, heading, stop)
    assert (again.ahead, again.aside) == pytest.approx((ahead, aside), abs=1e-15)
    assert base.halt(again).duration == pytest.approx(base.halt(motion).duration, abs=1e-6) or motion.stands


@given(speeds, speeds, st.sampled_from([BURGER, WHEELLESS]))
def test_reach_bounds_every_way(vx, vy, body):
    base, motion = Kinematics(body, PERIOD), Motion(0.0, vx, vy)
    to = base.limited(motion, (vx, vy))
    arcs = [*base.drive(motion, *to), base.halt(base.driven(motion, *to))]
    way = sum(math.hypot(arc.ahead, arc.aside) * arc.duration for arc in arcs)
    if base.rim(vx, vy) <= body.speed:
        assert way <= base.reach(math.hypot(vx, vy)) * (1.0 + 1e-12)
