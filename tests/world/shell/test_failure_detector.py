"""Robots without a token, without a process, without an answer. There is no bus, and time is injected."""

from collections.abc import Mapping

import pytest

from protocol.joining import Join
from protocol.messages import Command, Tick
from tests.world.driving import Stopwatch, two
from world.shell.admission import CHANCES, Admissions
from world.shell.failure_detector import FailureDetector, returning
from world.shell.pacing import REPEAT, Pacing
from world.shell.run import JudgedRun, Phase

GATHERING, PATIENCE, GRACE = 20.0, 5.0, 3.0


class Watch:
    """A failure detector of a run of two robots, and the notices that it sent to each."""

    def __init__(self, *, grace: float = 0.0, restarts: int = 0, lockstep: bool = True) -> None:
        self.clock, self.told, self.said = Stopwatch(), list[dict[int, Tick]](), list[str]()
        self.pacing = Pacing(lockstep, 0.0, self.clock)
        self.turn = JudgedRun(two())
        self.admissions = Admissions("r", self.turn.world, lockstep, self.clock)
        self.failures = FailureDetector(
            self.turn,
            self.admissions,
            self.pacing,
            self.tell,
            gathering=GATHERING,
            patience=PATIENCE,
            grace=grace,
            restarts=restarts,
            warn=self.said.append,
        )

    def tell(self, measurements: Mapping[int, Tick]) -> None:
        self.told.append(dict(measurements))

    def come(self, robot: int, session: str = "") -> None:
        session = session or f"session {robot}"
        self.admissions.enlist(Join(robot, session))
        self.failures.arrive(robot, session)

    def miss(self, robot: int) -> None:
        self.failures.miss(robot, self.admissions.slots[robot].session)

    def open(self) -> None:
        """Both have come, and the tick begins."""
        self.come(1)
        self.come(2)
        assert self.gathered() == {1, 2}
        self.turn.opened = True
        self.pacing.begin(self.turn.world.tick, 0.05)
        self.told.clear()

    def gathered(self) -> set[int] | None:
        measurements = self.failures.gather()
        return None if measurements is None else set(measurements)

    def command(self, robot: int) -> None:
        world = self.turn.world
        assert world.accept(Command(robot, world.lives.incarnations[robot], world.tick, (0.0, 0.0)))

    def close(self) -> None:
        self.turn.world.close_tick()
        self.turn.opened = False

    def go_by(self, seconds: float) -> None:
        """Time goes by, and the detector looks then, as the node does."""
        self.clock.now += seconds
        self.failures.look(self.clock.now)
        self.failures.wait(self.clock.now)


@pytest.mark.parametrize(
    ("restarts", "lockstep", "waits"), [(0, False, False), (1, False, True), (1, True, False)]
)
def test_real_time_goes_on_while_a_process_may_be_started_again(
    restarts: int, lockstep: bool, waits: bool
) -> None:
    assert returning(GATHERING, restarts, lockstep=lockstep) == (GATHERING if waits else 0.0)


def test_no_tick_opens_before_all_have_joined_and_show_their_tokens() -> None:
    watch = Watch()
    assert watch.gathered() is None
    watch.come(1)
    watch.admissions.enlist(Join(2, "b"))
    assert watch.gathered() is None
    watch.failures.arrive(2, "b")
    watch.miss(1)
    assert watch.gathered() is None
    watch.come(1, "another")
    assert watch.told == []
    assert watch.gathered() == {1, 2}


@pytest.mark.parametrize("joins", [False, True])
def test_a_run_that_is_not_complete_in_time_does_not_begin(joins: bool) -> None:
    watch = Watch()
    watch.come(1)
    if joins:
        watch.admissions.enlist(Join(2, "without a token"))
    assert watch.gathered() is None
    watch.go_by(GATHERING)
    assert not watch.turn.world.verdict
    watch.go_by(0.1)
    assert watch.turn.world.verdict == "aborted"
    assert watch.turn.world.referee.reason == "no sign of robot 2 within 20 s"


def test_without_a_grace_a_token_that_goes_takes_its_robot_along() -> None:
    watch = Watch()
    watch.open()
    watch.failures.miss(2, "another")
    assert watch.turn.world.exchange.active == (1, 2)
    watch.miss(2)
    assert watch.turn.world.exchange.active == (1,)
    assert watch.turn.world.lives.given_up == [(0, 2, 1, "has gone: it ended, or is cut off")]
    assert [set(told) for told in watch.told] == [{1}]  # robots that wait for its State are told
    assert watch.told[0][1].active == (1,)
    assert watch.said == ["tick 0: gives up robot 2, which has gone: it ended, or is cut off"]
    assert watch.admissions.slots[2].session == ""


def test_within_the_grace_a_token_comes_back_and_the_tick_is_told_again() -> None:
    watch = Watch(grace=GRACE)
    watch.open()
    watch.go_by(REPEAT)
    watch.miss(1)
    watch.miss(2)
    watch.go_by(0.9 * GRACE)
    watch.told.clear()
    watch.failures.arrive(1, "session 1")
    assert watch.told == []  # the other is missing yet
    watch.failures.arrive(2, "session 2")
    watch.failures.arrive(2, "another")
    assert [set(told) for told in watch.told] == [{1, 2}]
    watch.go_by(REPEAT)
    assert len(watch.told) == 2  # soon again, as if it had just begun
    watch.go_by(GRACE)
    assert watch.turn.world.exchange.active == (1, 2)
    assert watch.said == []


def test_after_the_grace_it_is_given_up_and_an_open_tick_of_real_time_ends_meanwhile() -> None:
    watch = Watch(grace=GRACE, lockstep=False)
    watch.open()
    watch.miss(1)
    watch.failures.arrive(1, "session 1")
    assert watch.told == []
    watch.miss(2)
    watch.go_by(0.9 * GRACE)
    assert watch.pacing.waited() == 0.9 * GRACE
    watch.close()
    watch.go_by(0.0)
    assert watch.pacing.waited() == 0.0
    assert watch.turn.world.exchange.active == (1, 2)
    watch.go_by(0.2 * GRACE)
    assert watch.turn.world.exchange.active == (1,)
    watch.turn.world.lives.of[1].kill()
    watch.miss(1)
    assert watch.admissions.missing() == [], "it does not return"


def test_while_one_is_missing_no_other_is_given_up() -> None:
    watch = Watch(grace=100.0 * PATIENCE)
    watch.open()
    watch.go_by(REPEAT)
    watch.miss(2)
    for _ in range(20):
        watch.go_by(PATIENCE)
    assert watch.turn.world.exchange.active == (1, 2)
    watch.close()
    watch.told.clear()
    assert watch.gathered() is None
    assert watch.told == [{}]  # the next tick has not begun


@pytest.mark.parametrize(
    ("session", "active"), [("session 2", (1, 2)), ("blamed", (1, 2)), ("another", (1,))]
)
def test_another_process_takes_the_seat_of_one_that_is_missing(session: str, active: tuple[int, ...]) -> None:
    watch = Watch(grace=GRACE)
    watch.open()
    watch.admissions.slots[2].blamed["blamed"] = CHANCES
    watch.failures.supersede(Join(2, "another"))
    assert watch.turn.world.exchange.active == (1, 2)  # its token is there
    watch.miss(2)
    watch.failures.supersede(Join(2, session))
    assert watch.turn.world.exchange.active == active


def test_an_open_tick_is_told_again_before_anybody_is_given_up() -> None:
    watch = Watch()
    watch.open()
    watch.command(1)
    watch.go_by(2.0 * PATIENCE)
    assert [set(told) for told in watch.told] == [{1, 2}]
    assert watch.turn.world.exchange.active == (1, 2)
    watch.go_by(0.1)
    assert watch.turn.world.exchange.active == (1,)
    assert watch.admissions.slots[2].blamed == {"session 2": 1}
    assert watch.pacing.waited() == 0.0  # the others have as long again
    assert watch.admissions.is_present(2)  # it hangs, though its session lives
    assert len(watch.said) == 1


@pytest.mark.parametrize(("lockstep", "restarts", "lives"), [(True, 2, 2), (True, 0, 0), (False, 2, 0)])
def test_lockstep_waits_for_so_many_next_lives(lockstep: bool, restarts: int, lives: int) -> None:
    watch = Watch(restarts=restarts, lockstep=lockstep)
    watch.open()
    for life in range(3):
        watch.miss(2)
        watch.close()
        awaited = life < lives
        assert watch.turn.world.lives.awaited == ({2} if awaited else set())
        assert watch.admissions.processes.expected.get(2, 0) == min(life + 1, lives)
        if awaited:
            assert watch.gathered() is None
        watch.come(2, f"life {life}")
        assert watch.gathered() is not None
        watch.turn.opened = True
    watch.close()
    watch.turn.world.lives.of[2].restart()
    assert (watch.gathered() is None) == lockstep == bool(watch.told) == bool(watch.turn.world.lives.awaited)


@pytest.mark.parametrize("joins", [False, True])
def test_the_next_life_is_not_waited_for_for_ever(joins: bool) -> None:
    watch = Watch(restarts=1)
    watch.open()
    watch.close()
    watch.go_by(GATHERING + 0.1)  # a viewer has paused the run
    watch.miss(2)
    if joins:
        watch.admissions.enlist(Join(2, "without a token"))
    assert watch.gathered() is None
    watch.go_by(GATHERING)
    assert len(watch.said) == 1
    watch.go_by(0.1)
    assert not watch.turn.world.verdict
    assert watch.turn.world.lives.awaited == set()
    assert watch.gathered() is not None
    assert watch.turn.world.exchange.active == (1,)
    assert watch.said[1:] == ["tick 1: gives up robot 2, which gave no sign within 20 s"]


@pytest.mark.parametrize("phase", [Phase.SHUTDOWN, Phase.CLOSING])
def test_a_robot_that_leaves_at_the_end_is_neither_named_nor_awaited(phase: Phase) -> None:
    watch = Watch(restarts=1)
    watch.open()
    watch.close()
    watch.turn.phase = phase
    watch.miss(2)
    assert watch.said == watch.turn.world.lives.given_up == []
    assert watch.turn.world.lives.awaited == set()
    assert watch.admissions.processes.expected == {}
