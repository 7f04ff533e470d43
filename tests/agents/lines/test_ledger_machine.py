"""Three whole ledgers under any order of events: no contact, and each pair has a line that both obey."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from agents.lines.boundary import RoundBoundary
from agents.lines.safe_velocity import safe_velocity
from agents.lines.separating_lines import SeparatingLines
from agents.peers.state import addressed_to
from protocol.messages import Member, State

SPEED, PERIOD, ROOM = 0.4, 0.05, 0.3  # fast, so that a few ticks suffice to collide
RADII = {1: 0.04, 2: 0.03, 3: 0.05}
STARTS = {1: (-0.06, 0.0), 2: (0.03, 0.0), 3: (0.0, 0.11)}
robots = st.sampled_from(sorted(RADII))
angles = st.floats(0.0, 2.0 * math.pi)
wishes = st.fixed_dictionaries(dict.fromkeys(RADII, st.floats(-0.5, 0.5)))  # off the way to the next robot


def polar(size: float, angle: float) -> tuple[float, float]:
    return size * math.cos(angle), size * math.sin(angle)


class Fleet(RuleBasedStateMachine):
    """Truth, ledgers, and every State that was ever sent."""

    @initialize(known=st.booleans(), bound=st.sampled_from([0.0, 0.002]))
    def begin(self, known: bool, bound: float) -> None:
        self.tick = 0
        self.bound = bound
        self.truth = dict(STARTS)
        self.error = dict.fromkeys(RADII, (0.0, 0.0))
        self.incarnation = dict.fromkeys(RADII, 1)
        self.down: dict[int, Member] = {}
        self.sent: list[State] = []
        self.ledger = {robot: self.newborn(robot, STARTS if known else None) for robot in RADII}

    def newborn(self, robot: int, starts: dict[int, tuple[float, float]] | None) -> SeparatingLines:
        live = (Member(i, self.incarnation[i], "live", RADII[i], founding=1) for i in RADII)
        ledger = SeparatingLines(
            robot,
            self.incarnation[robot],
            RADII,
            speed=SPEED,
            period=PERIOD,
            members={each.robot: self.down.get(each.robot, each) for each in live},
            starts=starts,
        )
        ledger.locate(self.tick, self.estimate(robot), self.bound)
        return ledger

    def estimate(self, robot: int) -> tuple[float, float]:
        (x, y), (ex, ey) = self.truth[robot], self.error[robot]
        return x + ex, y + ey

    @rule(robot=robots, angle=angles, share=st.floats(0.0, 1.0))
    def measure(self, robot: int, angle: float, share: float) -> None:
        self.error[robot] = polar(self.bound * share, angle)
        self.ledger[robot].locate(self.tick, self.estimate(robot), self.bound)

    def towards_next(self, robot: int, turn: float) -> tuple[float, float]:
        """Full speed at another robot, so that only the lines keep them apart."""
        (x, y), (px, py) = self.truth[robot], self.truth[robot % len(RADII) + 1]
        return polar(SPEED, math.atan2(py - y, px - x) + turn)

    @rule(robot=robots, turn=st.floats(-0.5, 0.5))
    def entries(self, robot: int, turn: float) -> None:
        desired = self.towards_next(robot, turn)
        proposals, answers = self.ledger[robot].entries(desired)
        self.sent.append(
            State(
                robot,
                self.incarnation[robot],
                self.tick,
                self.estimate(robot),
                self.bound,
                0.0,
                0.0,
                desired,
                proposals=proposals,
                answers=answers,
            )
        )

    @precondition(lambda self: self.sent)
    @rule(back=st.integers(0, 40), robot=robots)
    def deliver(self, back: int, robot: int) -> None:
        state = self.sent[-1 - back % len(self.sent)]
        if state.robot != robot:
            self.ledger[robot].on_state(addressed_to(robot, state, RADII[state.robot]))

    @rule(wish=wishes, ticks=st.integers(1, 4))
    def drive(self, wish: dict[int, float], ticks: int) -> None:
        for _ in range(ticks):
            moved = {robot: self.executed(robot, turn) for robot, turn in wish.items()}
            self.tick += 1
            for robot, (x, y) in moved.items():
                self.truth[robot] = (x, y)
                self.ledger[robot].locate(self.tick, self.estimate(robot), self.bound)
            self.apart()

    @rule(ticks=st.integers(1, 6), wish=wishes)
    def converse(self, ticks: int, wish: dict[int, float]) -> None:
        """An undisturbed stretch, so that lines come about and move."""
        for _ in range(ticks):
            states = len(self.sent)
            for robot, turn in wish.items():
                self.entries(robot, turn)
            for state, robot in itertools.product(self.sent[states:], RADII):
                if state.robot != robot:
                    self.ledger[robot].on_state(addressed_to(robot, state, RADII[state.robot]))
            self.drive(wish, 1)

    def executed(self, robot: int, turn: float) -> tuple[float, float]:
        x, y = self.truth[robot]
        ledger = self.ledger[robot]
        if robot in self.down or not ledger.ready:
            return x, y
        room = ROOM - RADII[robot] - self.bound
        vx, vy = safe_velocity(
            self.towards_next(robot, turn),
            self.estimate(robot),
            ledger.half_planes(),
            boundary=RoundBoundary(room),
            speed=SPEED,
            period=PERIOD,
        )
        return x + vx * PERIOD, y + vy * PERIOD

    @rule(robot=robots)
    def restart(self, robot: int) -> None:
        self.incarnation[robot] += 1
        self.down.pop(robot, None)
        self.ledger[robot] = self.newborn(robot, None)

    @rule(robot=robots)
    def fence(self, robot: int) -> None:
        radius, place = RADII[robot], self.truth[robot]
        self.down[robot] = Member(robot, self.incarnation[robot], "standing", radius, place, founding=1)

    @precondition(lambda self: self.down)
    @rule(robot=robots)
    def announce(self, robot: int) -> None:
        for member in self.down.values():
            if member.robot != robot:
                self.ledger[robot].on_member(member)

    @invariant()
    def apart(self) -> None:
        """No two disks touch."""
        for one, other in itertools.combinations(RADII, 2):
            assert math.dist(self.truth[one], self.truth[other]) >= RADII[one] + RADII[other]

    @invariant()
    def shared(self) -> None:
        """Of every pair that may both move, each obeys a line that the other obeys too."""
        for one, other in itertools.combinations(RADII, 2):
            owner, follower = self.ledger[one]._pairs[other], self.ledger[other]._pairs[one]
            if owner.end.agreed and follower.end.agreed and not self.down.keys() & {one, other}:
                assert set(follower.end.obeyed) <= set(owner.end.obeyed)

    @invariant()
    def ready(self) -> None:
        """Who is ready has something between it and each peer that is there, however that was found."""
        for ledger in self.ledger.values():
            assert ledger.ready == all(pair.ready for pair in ledger._pairs.values())

    @invariant()
    def settled(self) -> None:
        """What a settled pair keeps at hand is the only line that it obeys; nothing else is left of it."""
        for pair in itertools.chain.from_iterable(ledger._pairs.values() for ledger in self.ledger.values()):
            if pair.settled:
                (line,) = pair.end.obeyed
                side = line.side(pair.own_radius, pair.owns)
                assert (pair.nx, pair.ny, pair.limit) == (side.nx, side.ny, side.limit)
                assert line.gap(0.3, 0.2) == pytest.approx(
                    (pair.offset - pair.nx * 0.3 - pair.ny * 0.2) * (1.0 if pair.owns else -1.0)
                )
                assert pair.end.agreed
                assert pair.disk is None


Fleet.TestCase.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
TestFleet = Fleet.TestCase


def test_the_machine_would_notice_a_robot_that_moves_before_it_has_a_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(SeparatingLines, "ready", True)
    brief = settings(
        max_examples=200, phases=(Phase.generate,), derandomize=True, database=None, deadline=None
    )
    with pytest.raises(AssertionError):
        run_state_machine_as_test(Fleet, settings=brief)


@pytest.mark.slow
def test_the_machine_would_notice_a_follower_that_adopts_blindly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SeparatingLines, "_follower_fits", lambda self, line: True)  # noqa: ARG005
    brief = settings(
        max_examples=1500, phases=(Phase.generate,), derandomize=True, database=None, deadline=None
    )
    with pytest.raises(AssertionError):
        run_state_machine_as_test(Fleet, settings=brief)
