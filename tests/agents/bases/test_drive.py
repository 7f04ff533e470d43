"""Whenever each velocity takes effect, and whenever its robot's process dies: a base stays in its sweep."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import replace

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from agents.bases.drive import Drive
from protocol.bodies.kinematics import Arc, Kinematics, Motion, chord, turned
from protocol.bodies.sweep import Sweep, Tolerance, sweep
from protocol.scenario.body import DECISION, PRESETS, Base, Body

STEP = 5  # ms; all times are multiples
PERIOD = 0.1  # s
EXACT = {"error": 0.0, "lag": 0.0, "play": 0.0}  # what is left is what comes late
BURGER = replace(PRESETS["turtlebot3-burger"], **EXACT)
WHEELLESS = Body("omnidirectional", speed=0.22, acceleration=0.66)
SPINNING = Body("differential-drive", 0.1, 0.02, 0.1, 0.5, 5.0)
ROUNDING = 1e-9  # m
STILL = (0.0, 0.0)

velocities = st.one_of(
    st.just(STILL),
    st.tuples(st.sampled_from([0.22, 0.1, 0.03]), st.floats(-math.pi, math.pi)).map(
        lambda polar: (polar[0] * math.cos(polar[1]), polar[0] * math.sin(polar[1]))
    ),
)
ticks = st.tuples(
    velocities, st.integers(4, 30), st.integers(0, round(DECISION * 1000) // STEP), st.integers(1, 6)
)
WORST = ("toward", "left", "right", "early", "late")


class Told:
    """A robot's process: velocities by when they were published, ms."""

    def __init__(self, body: Body, base: Base) -> None:
        self.kinematics, self.base = Kinematics(body, PERIOD), base
        self.drive = Drive(body, base, PERIOD)
        self.late = Tolerance(body, late=base.lateness)
        self.now, self.times, self.velocities = 0, [-math.inf], [STILL]
        self.heading = 2.0  # rad, of the base at its newest odometry

    def run(self, until: int) -> None:
        """Publish what is due, from the present on."""
        while True:
            self.drive.advance(self.now / 1000)
            self.times.append(self.now)
            self.velocities.append(self.drive.told)
            if self.now >= until:
                return
            self.now += STEP

    def command(self, velocity, age: int, decision: int) -> Sweep | None:
        """A tick begins with odometry of an estimated age, ms; returns the sweep of what it commands, or of
        what goes on if that is to brake; None if it stands."""
        now = self.now / 1000
        heading = self.heading + self.drive.turning((age - decision) / 1000, now)
        said = self.drive.motion(heading, now)
        assert said is not None
        motion = self.kinematics.motion(said.velocity, said.heading, said.stop, said.before)
        self.now += decision
        if velocity == STILL:
            self.drive.command(STILL, heading, self.now / 1000, math.inf)
            return None if motion.stands else sweep(self.kinematics, motion, self.late)
        to = self.kinematics.limited(motion, velocity)
        self.drive.command(Motion(motion.heading, *to).velocity, heading, self.now / 1000, math.inf)
        return sweep(self.kinematics, motion, self.late, to)

    def between(self, begin: float, end: float):
        """Velocities that were the newest at some time between two, ms."""
        return self.velocities[bisect_right(self.times, begin) - 1 : bisect_right(self.times, end)]


def excess(told: Told, passed: Sweep, since: int, heard: int, worst, toward: float) -> float:
    """By how much the base leaves a sweep at most in a direction from its place at `since` on, m, if its
    robot's process dies after `heard`, ms."""
    kinematics, base = told.kinematics, told.base
    late, patience = round(base.latency * 1000), round(base.timeout * 1000)
    nx, ny = math.cos(toward), math.sin(toward)
    x, y, heading, most, now = 0.0, 0.0, told.heading, -passed.extent(nx, ny), since
    while now < heard + late + patience:
        effective = told.between(now - late, min(now, heard))
        choice = worst[0] if now < worst[2] else worst[1]
        if choice == "toward":
            velocity = max(
                effective, key=lambda each: nx * turned(*each, heading)[0] + ny * turned(*each, heading)[1]
            )
        elif choice in ("left", "right"):
            velocity = max(effective, key=lambda each: each[1] * (1 if choice == "left" else -1))
        else:
            velocity = effective[-1 if choice == "early" else 0]
        arc = Arc(*velocity, STEP / 1000)
        dx, dy = turned(*chord(arc, kinematics.turn(arc)), heading)
        x, y, heading, now = x + dx, y + dy, heading + kinematics.turn(arc), now + STEP
        most = max(most, nx * x + ny * y - passed.extent(nx, ny))
    braking = Motion(heading, *velocity)
    while not braking.stands:
        arc = kinematics.coast(braking, STEP / 1000)
        dx, dy = turned(*chord(arc, kinematics.turn(arc)), braking.heading)
        x, y, braking = x + dx, y + dy, kinematics.coasted(braking, STEP / 1000)
        most = max(most, nx * x + ny * y - passed.extent(nx, ny))
    return most


def worst_excess(body, latency, least, unknown, history, last, decision, ends, worst, toward) -> float:
    base = Base(latency=latency / 1000, delay=least * latency / 1000, patience=STEP / 1000)
    told = Told(base.carries(body), base)
    for velocity, gap, decided, repeated in history:
        for _ in range(repeated):
            told.command(velocity, 0, decided * STEP)
            told.run(told.now + gap * STEP)
    decided = decision * STEP
    oldest = round((base.age + base.latency) * 1000)
    passed = told.command(last, oldest, decided)
    begun = told.now
    since = begun - oldest - round(unknown * (base.latency - base.delay) * 1000) // STEP * STEP
    if passed is None:
        return -math.inf
    told.run(begun + ends[0] * STEP)
    for decided in ends[1]:
        told.command(STILL, 0, decided * STEP)
        told.run(told.now + ends[0] * STEP)
    if ends[1]:
        told.run(told.now + 600)
    choices = (*worst[:2], begun + worst[2] * STEP)
    return excess(told, passed, since, told.now, choices, toward)


cases = st.tuples(
    st.sampled_from([BURGER, WHEELLESS, SPINNING]),
    st.sampled_from([0, 30, 60]),  # ms, latency
    st.sampled_from([0.0, 0.5, 1.0]),  # of it, stated as the least delay
    st.sampled_from([0.0, 1.0]),  # of what is not known of that
    st.lists(ticks, min_size=1, max_size=5),
    velocities,
    st.integers(0, round(DECISION * 1000) // STEP),
    st.tuples(st.integers(0, 50), st.lists(st.integers(0, 10), max_size=6)),  # and then it is told to brake
    st.tuples(st.sampled_from(WORST), st.sampled_from(WORST), st.integers(-30, 30)),
    st.floats(-math.pi, math.pi),
)


AHEAD, LATE = (0.22, 0.0), ("late", "late", 0)
TOLD_TO_BRAKE = (WHEELLESS, 0, 1.0, 0.0, [(AHEAD, 20, 0, 12)], STILL, 0, (0, [10] * 20), LATE, 0.0)
HAS_BRAKED = [(AHEAD, 20, 0, 3), (STILL, 9, 1, 3), (STILL, 2, 10, 4)]


@given(cases)
@example(TOLD_TO_BRAKE)  # again and again, and each time after as long a decision as there may be
@example((WHEELLESS, 0, 1.0, 0.0, HAS_BRAKED, STILL, 1, (0, []), LATE, 0.0))  # of which it is told late
def test_a_base_stays_in_its_sweep_whenever_each_velocity_takes_effect(case):
    assert worst_excess(*case) <= ROUNDING


SLOWER = [((-0.2194, 0.016), 20, 10, 12), ((-0.0168, -0.0249), 4, 0, 2)]
TURNED = (SLOWER, (0.0, 0.22), 0, (12, []), ("toward", "toward", 14), -3.37)
ALONE = ([((0.22, 0.0), 20, 0, 12)], (0.0, 1e-4), 0, (0, []), ("late", "late", 0), 0.0)
TERMS = {
    "odometry is old": ("_age", TURNED),
    "velocities take effect late": ("_latency", TURNED),
    "a process dies": ("alone", ALONE),
}


@pytest.mark.parametrize("term", TERMS)
def test_without_this_term_it_leaves_it(term, monkeypatch):
    name, case = TERMS[term]
    case, made = (WHEELLESS, 60, 0.0, 1.0, *case), Tolerance.__init__

    def without(tolerance: Tolerance, *arguments: object, **named: object) -> None:
        made(tolerance, *arguments, **named)
        setattr(tolerance, name, 0.0)

    assert worst_excess(*case) <= ROUNDING
    monkeypatch.setattr(Tolerance, "__init__", without)
    assert worst_excess(*case) > 1e-3


@pytest.mark.parametrize("steps", [0, 2])  # of its acceleration that it has sent
@pytest.mark.parametrize("pause", [0.02, 0.07, 0.5])  # s, beyond when the next step is due
def test_a_process_that_goes_on_late_sends_nothing_faster_and_drives_when_its_base_stands(steps, pause):
    base = Base()
    drive = Drive(base.carries(BURGER), base, PERIOD)
    drive.command((0.06, 0.0), 0.0, 0.0, math.inf)
    for _ in range(steps):
        drive.advance(now := drive.due)
    held, now = drive.told[0], drive.due + pause
    drive.advance(now)
    assert drive.told[0] < held or held == 0.0
    begun, fell = now, [held]
    while drive.told != STILL or drive.motion(0.0, now) is None:
        assert drive.told[0] <= fell[-1]
        fell.append(drive.told[0])
        if drive.motion(0.0, now) is None:
            assert drive.told == STILL
            drive.command((0.06, 0.0), 0.0, now, math.inf)
        drive.advance(now := now + 0.01)
    is_long = pause > base.timeout / 3.0 + base.latency
    unknown = base.lateness.alone + base.lateness.window + BURGER.speed / BURGER.acceleration
    assert (now - begun >= unknown) is (is_long and steps > 0)
    drive.command((0.06, 0.0), 0.0, now, math.inf)
    drive.advance(now)
    assert drive.told[0] > 0.0
