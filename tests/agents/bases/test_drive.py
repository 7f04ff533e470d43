"""Whenever each velocity takes effect, and whenever its robot's process dies: a base stays in its sweep."""

import math
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.bases.drive import OFTEN, Drive
from protocol.bodies.kinematics import Arc, Kinematics, Motion, chord, turned
from protocol.bodies.sweep import Sweep, Tolerance, sweep
from protocol.scenario.body import DECISION, PRESETS, Base, Body

STEP = 5  # ms; all times are multiples
PERIOD = 0.1  # s
BURGER = replace(PRESETS["turtlebot3-burger"], error=0.0, lag=0.0, play=0.0)  # what comes late is left
WHEELLESS = Body("omnidirectional", speed=0.22, acceleration=0.66)
SPINNING = Body("differential-drive", 0.1, 0.02, 0.1, 0.5, 5.0)
SLUGGISH = Body("differential-drive", 0.1, 0.06, 0.2, 0.22, 0.3)
ROUNDING = 1e-9  # m
STILL = (0.0, 0.0)
TICKS = st.tuples(
    st.one_of(
        st.just(STILL),
        st.tuples(st.sampled_from([0.22, 0.1, 0.03]), st.floats(-math.pi, math.pi)).map(
            lambda polar: (polar[0] * math.cos(polar[1]), polar[0] * math.sin(polar[1]))
        ),
    ),
    st.integers(0, 30),  # STEP, since the Command before
    st.integers(0, round(DECISION * 1000) // STEP),  # of the decision
)
WORST = ("toward", "left", "right", "early", "late")


class Process:
    """A robot's process: velocities by when they were published, ms.

    Args:
        pauses: for which it is suspended before each of its actions, in `STEP`.
    """

    def __init__(self, body: Body, base: Base, pauses: Iterable[int]) -> None:
        self.kinematics, self.base = Kinematics(body, PERIOD), base
        self.drive = Drive(body, base, PERIOD)
        self.late = Tolerance(body, late=base.lateness)
        self.now, self.times, self.velocities = 0, [-math.inf], [STILL]
        self.begun = 0  # ms, of the newest tick
        self.oldest = round((base.age + base.latency) * 1000)  # ms, odometry with which it moves
        self.heading = 2.0  # rad, of the base at its newest odometry
        self._pauses = iter(pauses)

    def run(self, until: int) -> None:
        """Publish what is due before a time."""
        while (due := self.drive.due * 1000) < until:
            self.now = max(self.now, STEP * math.ceil(due / STEP - 1e-6))
            self._publish()
        self.now = max(self.now, until)

    def command(self, velocity, age: int, decision: int) -> Sweep | None:
        """A tick begins with odometry of an estimated age, ms; returns the sweep of what it commands, or of
        what goes on if that is to brake; None if it stands, or its motion is unknown."""
        self._pause()
        self.begun, heading = self.now, self.heading + self.drive.turning(age / 1000, self.now / 1000)
        said = self.drive.motion(heading, self.begun / 1000)
        self.now += decision
        self._pause()
        taken = self.now - self.begun
        if said is None or taken > DECISION * 1000 or age + taken > self.oldest:
            velocity = STILL
        self.drive.command(velocity, heading, self.now / 1000, math.inf)
        self._send()
        if said is None:
            return None
        motion = self.kinematics.motion(said.velocity, said.heading, said.stop, said.before)
        if velocity != STILL and self.drive.due < math.inf:
            return sweep(self.kinematics, motion, self.late, self.kinematics.limited(motion, velocity))
        return None if motion.stands else sweep(self.kinematics, motion, self.late)

    def between(self, begin: float, end: float):
        """Times and velocities that were the newest at some time between two, ms."""
        some = slice(bisect_right(self.times, min(begin, end)) - 1, bisect_right(self.times, end))
        return zip(self.times[some], self.velocities[some], strict=True)

    def newest(self, now: float) -> float:
        """When it published last before a time, ms."""
        return self.times[bisect_right(self.times, now) - 1]

    def _pause(self) -> None:
        self.now += next(self._pauses, 0) * STEP

    def _publish(self) -> None:
        self._pause()
        self._send()

    def _send(self) -> None:
        self.drive.advance(self.now / 1000 + 1e-9)  # what is due by rounding, too
        self.times.append(self.now)
        self.velocities.append(self.drive.velocity)


def excess(process: Process, passed: Sweep, since: int, died: int, worst, toward: float) -> float:
    """By how much the base leaves a sweep at most in a direction from its place at `since` on, m, if the
    process dies after it has published at `died`, ms."""
    kinematics, base = process.kinematics, process.base
    late, timeout = round(base.latency * 1000), round(base.timeout * 1000)
    nx, ny = math.cos(toward), math.sin(toward)
    x, y, now, most = 0.0, 0.0, since, -passed.extent(nx, ny)
    motion = Motion(process.heading)
    step = kinematics.period / kinematics.steps + 0.5 * base.latency  # s, of braking
    while now < died + late + timeout or motion.velocity != STILL:
        choice = worst[0] if now < worst[2] else worst[1]
        alone = late + (timeout / OFTEN if choice == "early" else timeout)
        effective = [
            velocity for at, velocity in process.between(now - late, min(now, died)) if now < at + alone
        ]
        ahead, aside = turned(nx, ny, -motion.heading)
        if not effective:  # it brakes by itself
            velocity = STILL
        elif choice == "toward":
            velocity = max(effective, key=lambda each: ahead * each[0] + aside * each[1])
        elif choice in ("left", "right"):
            velocity = max(effective, key=lambda each: each[1] * (1 if choice == "left" else -1))
        else:
            velocity = effective[-1 if choice == "early" else 0]
        if velocity == STILL and (not effective or kinematics.coasted(motion, step).velocity != STILL):
            motion = kinematics.braking(motion)
            arc = kinematics.coast(motion, STEP / 1000)
            after = kinematics.coasted(motion, STEP / 1000)
        else:
            arc = Arc(*velocity, STEP / 1000)
            after = Motion(motion.heading + kinematics.turn(arc), *velocity)
        dx, dy = chord(arc, kinematics.turn(arc), motion.heading)
        x, y, motion, now = x + dx, y + dy, after, now + STEP
        most = max(most, nx * x + ny * y - passed.extent(nx, ny))
    return most


def worst_excess(body, base, unknown, pauses, history, last, tail, death, worst, toward) -> float:
    base = Base(
        timeout=base[0] / 1000,
        latency=base[1] / 1000,
        delay=base[2] * base[1] / 1000,
        patience=base[3] / 1000,
        age=base[4] / 1000,
    )
    process = Process(base.carries(body), base, pauses)
    for velocity, gap, decision in history:
        process.run(process.now + gap * STEP)
        process.command(velocity, 0, decision * STEP)
    process.run(process.now + last[1] * STEP)
    decision = last[2] * STEP
    age = process.oldest - (0 if last[0] == STILL else decision)
    passed = process.command(last[0], age, decision)
    begun, since = process.now, process.begun - age
    if passed is None:
        return -math.inf
    died = math.inf
    for velocity, gap, decision in tail:
        process.run(process.now + gap * STEP)
        process.command(velocity, 0, decision * STEP)
        if velocity != STILL and process.drive.due < math.inf:
            died = min(died, process.now - STEP)  # what counts from now on is the sweep of that tick
    process.run(process.now + 600)
    since -= round(unknown * (base.latency - base.delay) * 1000) // STEP * STEP
    died = min(died, max(begun, process.newest(begun + death * STEP)))
    return excess(process, passed, since, died, (*worst[:2], begun + worst[2] * STEP), toward)


cases = st.tuples(
    st.sampled_from([BURGER, WHEELLESS, SPINNING, SLUGGISH]),
    st.tuples(  # of the base, in ms
        st.sampled_from([45, 90, 240]),  # its timeout
        st.sampled_from([10, 30, 60]),  # latency
        st.sampled_from([0.0, 0.5, 1.0]),  # of that, stated as the least delay
        st.sampled_from([0, 5, 100]),  # patience
        st.sampled_from([5, 100]),  # age of odometry
    ),
    st.sampled_from([0.0, 1.0]),  # of what is not known of the delay
    st.lists(st.sampled_from([0, 0, 0, 0, 0, 1, 2, 3, 5, 10, 20, 60]), max_size=60),  # pauses
    st.lists(TICKS, min_size=1, max_size=5),
    TICKS,
    st.lists(TICKS, max_size=5),
    st.integers(0, 120),  # STEP until the process dies
    st.tuples(st.sampled_from(WORST), st.sampled_from(WORST), st.integers(-30, 30)),
    st.floats(-math.pi, math.pi),
)


@given(cases)
def test_a_base_stays_in_its_sweep_whenever_each_velocity_takes_effect(case):
    assert worst_excess(*case) <= ROUNDING


def without(term: str):
    """Have tolerances leave a term out."""
    made = Tolerance.__init__

    def make(tolerance: Tolerance, *arguments: object, **named: object) -> None:
        made(tolerance, *arguments, **named)
        setattr(tolerance, term, 0.0)

    return Tolerance, "__init__", make


def brakes(drive: Drive, now: float) -> None:
    if drive.velocity != STILL and now > drive.due + 0.5 * drive._base.latency:
        drive._brake(round(now, 6))


AHEAD = (0.22 * math.cos(2.0), 0.22 * math.sin(2.0))
BACK, AGAIN = [((-0.22, 0.0), 19, 0), ((0.03, 0.0), 22, 0)], [((-0.1, 0.0), 20, 0)]
SLOW = [3, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 20, 0, 0, 3, 0, 0, 0, 0, 20]
RULES = {
    "odometry is old": (
        without("_age"),
        (WHEELLESS, (45, 60, 0.0, 100, 100), 1.0, [], BACK, (STILL, 20, 0)),
        ([], 11, ("toward", "late", -2), -math.pi),
    ),
    "velocities take effect late": (
        without("_latency"),
        (SPINNING, (45, 60, 1.0, 5, 5), 1.0, [], AGAIN, ((0.1, 0.0), 26, 0)),
        ([], 0, ("toward", "toward", -4), math.pi),
    ),
    "a process dies": (
        without("alone"),
        (SLUGGISH, (240, 10, 1.0, 0, 5), 0.0, [], [((0.22, 0.0), 20, 3)], ((-0.1, 0.0), 20, 6)),
        ([], 3, ("toward", "late", -2), -0.11),
    ),
    "a process that is late commands rest, and does not brake": (
        (Drive, "_check", brakes),
        (WHEELLESS, (240, 10, 1.0, 0, 5), 0.0, [], [(AHEAD, 20, 0)] * 4, (STILL, 20, 10)),
        ([], 0, ("toward", "toward", 0), 2.0),
    ),
    "nor goes on": (
        (Drive, "_check", lambda _drive, _now: None),
        (
            BURGER,
            (240, 10, 1.0, 0, 100),
            1.0,
            SLOW,
            [((0.22, 0.0), 20, 0), ((-0.03, 0.0), 30, 0), (STILL, 20, 0), ((-0.22, 0.0), 20, 0)],
            (STILL, 20, 0),
        ),
        ([(STILL, 20, 0)], 76, ("right", "toward", -2), math.pi),
    ),
}


@pytest.mark.parametrize("rule", RULES)
def test_without_this_it_leaves_it(rule, monkeypatch):
    patch, before, after = RULES[rule]
    assert worst_excess(*before, *after) <= ROUNDING
    monkeypatch.setattr(*patch)
    assert worst_excess(*before, *after) > 1e-3


@pytest.mark.parametrize("steps", [0, 2])  # of its acceleration that it has sent
@pytest.mark.parametrize("pause", [0.01, 0.02, 0.07, 0.5])  # s, beyond when the next step is due
def test_a_process_that_goes_on_late_commands_rest_and_drives_when_its_base_stands(steps, pause):
    base = Base()
    drive = Drive(base.carries(BURGER), base, PERIOD)
    drive.command((0.06, 0.0), 0.0, 0.0, math.inf)
    sent = 0.0
    for _ in range(steps):
        drive.advance(sent := drive.due)
    now, held = drive.due + pause, drive.velocity
    drive.advance(now)
    if pause < 0.5 * base.latency:
        assert drive.velocity[0] > held[0]
        return
    assert drive.velocity == STILL
    if steps == 0:  # it had not begun
        assert drive.motion(0.0, now) is not None
    while drive.motion(0.0, now) is None:
        drive.command((0.06, 0.0), 0.0, now, math.inf)
        drive.advance(now)
        assert drive.velocity == STILL
        now += 0.01
    unknown = base.lateness.alone + base.lateness.window + BURGER.speed / BURGER.acceleration
    assert steps == 0 or sent + unknown <= now <= sent + unknown + 0.02
    drive.command((0.06, 0.0), 0.0, now, math.inf)
    drive.advance(now)
    assert drive.velocity[0] > 0.0


def published(drive: Drive, until: float):
    """Times and velocities that are published before a time, s."""
    found = []
    while (due := drive.due) < until:
        drive.advance(due)
        found.append((due, drive.velocity))
    return found


def test_a_lease_that_ends_within_a_tick_ends_the_motion_then():
    base = Base()
    drive = Drive(base.carries(WHEELLESS), base, PERIOD)
    drive.command((0.06, 0.0), 0.0, 0.0, 0.05)
    speeds = {time: ahead for time, (ahead, _) in published(drive, 1.0)}
    last = speeds.pop(0.04)
    assert last == max(last, *speeds.values())
    assert min(speeds) == 0.0
    assert drive.velocity == STILL
    assert max(speeds) < 0.05 + last / WHEELLESS.acceleration + 0.02


def test_a_velocity_is_repeated_within_the_timeout_until_the_patience_is_over():
    base = Base(timeout=0.09, patience=0.2)
    drive = Drive(base.carries(WHEELLESS), base, PERIOD)
    drive.command((0.06, 0.0), 0.0, 0.0, math.inf)
    times = [time for time, _ in published(drive, 1.0)]
    assert max(after - before for before, after in pairwise(times)) <= base.timeout / OFTEN + ROUNDING
    assert times[-1] > PERIOD + base.patience


def test_a_motion_lasts_until_braking_begins_and_for_as_long_as_a_base_is_alone():
    base = Base(patience=0.07)
    drive = Drive(base.carries(WHEELLESS), base, PERIOD)
    drive.command((0.06, 0.0), 0.0, 0.0, math.inf)
    published(drive, PERIOD + 0.001)
    motion = drive.motion(0.0, PERIOD)
    assert motion is not None
    braking = 0.5 * 0.06**2 / WHEELLESS.acceleration
    assert motion.stop[0] == pytest.approx(0.06 * (base.patience + base.lateness.alone) + braking)


def test_a_velocity_may_act_for_a_window_after_the_next_one_is_published():
    base = Base(patience=1.0)
    drive = Drive(base.carries(WHEELLESS), base, PERIOD)
    drive.command((0.06, 0.0), 0.0, 0.0, math.inf)
    published(drive, PERIOD + 0.001)
    for after, known in ((-0.01, 2), (0.01, 1)):
        now = PERIOD + base.lateness.window + after
        published(drive, now)
        motion = drive.motion(0.0, now)
        assert motion is not None
        assert len(motion.before) == known
        assert motion.before[-1] == drive.velocity


@pytest.mark.parametrize("age", [0, 40, 95])
def test_a_base_turns_by_all_velocities_since_its_odometry_and_by_half_a_decision(age):
    base = Base(latency=0.06, delay=0.02)
    process = Process(base.carries(SPINNING), base, [])
    process.command((0.05, 0.08), 0, 0)
    process.run(85)
    since, turn = 85 - age - 20, 0.0
    for (begin, velocity), end in zip(
        zip(process.times, process.velocities, strict=True), [*process.times[1:], 85], strict=True
    ):
        turn += velocity[1] * max(0.0, end - max(begin, since)) / 1000 / SPINNING.offset
    turn += process.velocities[-1][1] * 0.5 * DECISION / SPINNING.offset
    assert process.drive.turning(age / 1000, 0.085) == pytest.approx(turn, abs=1e-6)
