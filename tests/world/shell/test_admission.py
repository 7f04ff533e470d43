"""Joining: idempotent for each process, one process for each robot, and no wait for dead processes. Leaving:
robots that owe a report, those to be notified, and for how long. There is no bus, and time is injected."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.joining import Admission, Finished, Join, JoinReply, Refusal, Wait
from protocol.messages import Health, Member
from tests.world.driving import Stopwatch, two
from world.coordinator.records import Life, LifeStatus
from world.shell.admission import RESERVATION, Admissions
from world.shell.checkpoint import Checkpoint
from world.shell.pacing import Pacing
from world.shell.run import SHUTDOWN, JudgedRun, Phase, Shutdown
from world.world import WorldCore


class Desk:
    """Admissions of one run of two robots, and what processes ask of it."""

    def __init__(self) -> None:
        self.clock = Stopwatch()
        self.run = JudgedRun(two())
        self.admissions = Admissions("r", self.run.world, True, self.clock)

    def ask(self, session: str, robot: int = 1, lived: int | None = None) -> JoinReply:
        health = None if lived is None else Health(robot, lived, 5, 0.0, 0, 0, {}, (), ())
        join = Join(robot, session, health)
        return self.admissions.refusal(join) or self.admissions.enlist(join)

    def arrive(self, session: str) -> None:
        self.admissions.arrive(1, session)

    def leave(self) -> None:
        """The token of robot 1's admitted process is gone, and it is taken to be gone as well."""
        self.admissions.go(1, self.admissions.slots[1].session)
        self.admissions.leave(1)

    def goes_on(self, incarnation: int) -> bool:
        """Whether this life of robot 1 is its newest, and goes on."""
        life = self.run.world.lives.of[1]
        return life.goes_on and life.incarnation == incarnation

    def admitted(self, session: str, robot: int = 1, lived: int | None = None) -> int:
        return self.ask(session, robot, lived).incarnation


@pytest.fixture
def desk() -> Desk:
    """The first process is there."""
    found = Desk()
    assert found.admitted("first") == 1
    found.arrive("first")
    return found


def test_a_life_that_was_lived_is_not_lived_again(desk: Desk) -> None:
    """Its numbers have been used."""
    assert desk.admitted("first", lived=1) == 2
    assert desk.admitted("first", lived=1) == 2  # the reply was lost
    assert desk.goes_on(2)


def test_robots_wait_for_another_world_only_if_one_can_continue(tmp_path: Path) -> None:
    path = tmp_path / "state"
    Checkpoint.create(path)
    checkpoint = Checkpoint(path, "r", two())
    for kept in (True, False):
        checkpoint.kept = kept
        admissions = Admissions("r", WorldCore(two()), True, checkpoint=checkpoint)
        assert (admissions.enlist(Join(1, "a")).grace > 0.0) == kept


def test_one_that_dies_before_its_token_is_there_makes_room() -> None:
    desk = Desk()
    assert desk.admitted("dead") == 1
    desk.clock.now = 0.9 * RESERVATION
    assert isinstance(desk.ask("next"), Wait)
    desk.clock.now = 1.1 * RESERVATION
    assert desk.admitted("next") == 2
    assert isinstance(desk.ask("dead"), Wait)  # it was only slow
    desk.arrive("next")
    assert isinstance(desk.ask("dead"), Refusal)
    assert desk.goes_on(2)


def test_a_second_process_is_refused_and_the_first_undisturbed(desk: Desk) -> None:
    desk.clock.now = 100.0
    reply = desk.ask("second")
    assert isinstance(reply, Refusal)
    assert "already running" in reply.text
    assert desk.goes_on(1)
    desk.leave()
    desk.run.world.lost(1)
    assert desk.admitted("second") == 2


def test_a_process_that_the_scenario_has_ended_is_not_its_own_successor(desk: Desk) -> None:
    """It may ask before its launcher gets to it, when the world or a router was away."""
    desk.run.world.lives.of[1].restart()
    assert isinstance(desk.ask("first"), Wait)
    desk.leave()  # a router went, and with it the token
    assert isinstance(desk.ask("first"), Wait)
    assert desk.admitted("next") == 2
    assert isinstance(desk.ask("first"), Wait)


def test_the_process_of_a_robot_that_was_removed_is_not_that_of_the_next_with_its_id(desk: Desk) -> None:
    """It may ask before it heard that it was removed, when its robot's id is taken again already."""
    desk.run.world.lives.of[1] = Life(1, LifeStatus.LOST, fenced=True, fate="removed")
    desk.admissions.expect(1)
    assert desk.ask("first") == Finished("removed")
    assert desk.ask("first") == Finished("removed")
    assert desk.admitted("next") == 2
    desk.arrive("next")
    assert desk.ask("first") == Finished("removed")
    assert desk.admitted("next") == 2


def test_a_process_that_lost_its_seat_while_the_scenario_held_it_still_goes_on(desk: Desk) -> None:
    """A process that is frozen for longer than its token lives is the one that it was when it is woken."""
    desk.run.world.lives.of[1].pause()
    desk.leave()
    desk.run.world.lost(1, "has gone")
    assert isinstance(desk.ask("first"), Wait)
    desk.run.world.lives.of[1].resume()
    assert desk.admitted("first") == 1
    assert not desk.admissions.is_present(1)
    desk.leave()
    desk.run.world.lives.of[1].pause()
    desk.run.world.lives.of[1].resume()
    assert desk.admitted("next") == 2  # it has not woken: its successor is not kept out


@given(
    st.lists(
        st.tuples(
            st.sampled_from(("ask", "ask", "lose", "arrive", "leave", "live", "wait")), st.sampled_from("abc")
        ),
        max_size=30,
    )
)
def test_no_two_processes_live_and_no_life_twice(events: list[tuple[str, str]]) -> None:
    """Processes a, b, c ask, hear or miss the reply, live, show a token, go, in any order."""
    desk = Desk()
    lives: dict[str, int] = {}  # processes that have started and not ended
    last: dict[str, int] = {}  # the life that it has ended
    begun: set[int] = set()
    token = ""
    for event, process in events:
        if event in ("ask", "lose") and process not in lives:
            reply = desk.ask(process, lived=last.get(process))
            if isinstance(reply, Admission) and event == "ask":
                assert reply.incarnation not in begun
                begun.add(reply.incarnation)
                lives[process] = reply.incarnation
        elif event == "arrive" and process in lives and token in ("", process):
            desk.arrive("next")
            token = process
        elif event == "leave" and token == process:
            desk.leave()
            desk.run.world.lost(1)
            token = ""
            lives.pop(process, None)
            last.pop(process, None)
        elif event == "live" and process in lives:
            last[process] = lives.pop(process)  # it says itself that it is over
        elif event == "wait":
            desk.clock.now += RESERVATION
        newest = desk.run.world.lives.incarnations[1]
        assert sum(life == newest for life in lives.values()) <= 1


# -- leaving


class Ending(Desk):
    """A run of two robots that are there."""

    def __init__(self) -> None:
        super().__init__()
        self.shutdown = Shutdown(self.run, self.admissions, Pacing(True, 0.0, self.clock))
        self.run.began = 0.0
        for robot in (1, 2):
            self.admissions.enlist(Join(robot, f"session {robot}"))
            self.admissions.arrive(robot, f"session {robot}")

    def report(self, robot: int, published: int | None = None) -> JoinReply | None:
        """A process asks to join, with a report of so many messages or without one."""
        health = None if published is None else Health(robot, 1, 5, 0.0, published, 0, {}, (), ())
        join = Join(robot, f"session {robot}", health)
        self.shutdown.take_report(join)
        return self.shutdown.reply(join)

    def told(self) -> set[int]:
        measurements = self.shutdown.final_ticks()
        assert all(measurement.over for measurement in measurements.values())
        return set(measurements)


def test_a_turn_that_runs_is_not_wound_up() -> None:
    end = Ending()
    end.clock.now = 2.0 * SHUTDOWN
    assert end.report(1, published=3) is None
    assert end.admissions.slots[1].health is None  # of a life that ended during the run
    assert not end.shutdown.is_reported()
    assert not end.shutdown.is_over()


def test_all_report_then_all_are_notified() -> None:
    end = Ending()
    end.run.world.finish("aborted", "for a test")
    end.shutdown.begin()
    assert end.run.phase is Phase.SHUTDOWN
    assert end.told() == {1, 2}
    assert isinstance(end.report(1, published=3), Wait)
    assert isinstance(end.report(1), Wait)  # asks again, and what it said stays
    assert end.told() == {2}
    assert not end.shutdown.is_reported()
    end.report(2, published=4)
    assert end.shutdown.is_reported()
    end.clock.now = 1.5
    end.run.world.lives.roster.put(Member(3, 0, "appearing", 0.04, (0.0, 0.0)))
    assert isinstance(end.shutdown.instead(end.ask("early", 3), 3), Wait)
    report = end.shutdown.report(10)
    assert report["messages"]["published"] == 17
    assert report["wall_time"] == 0.0  # up to the verdict
    end.shutdown.close()
    assert not end.shutdown.is_reported()
    assert end.told() == {1, 2}
    assert end.report(1) == Finished("aborted")
    assert end.told() == {2}
    assert not end.shutdown.is_over()
    assert end.report(2) == Finished("aborted")
    assert not end.shutdown.is_over()
    assert end.shutdown.instead(end.ask("early", 3), 3) == Finished("aborted")
    assert end.shutdown.is_over()


def test_no_process_waits_for_one_that_has_gone() -> None:
    end = Ending()
    end.shutdown.begin()
    end.report(1, published=3)
    end.admissions.leave(2)
    assert end.shutdown.is_reported()
    end.shutdown.close()
    end.report(1)
    assert end.shutdown.is_over()


def test_each_wait_is_bounded() -> None:
    end = Ending()
    end.shutdown.begin()
    end.clock.now = SHUTDOWN
    assert not end.shutdown.is_reported()
    end.clock.now = 1.01 * SHUTDOWN
    assert end.shutdown.is_reported()
    end.shutdown.close()
    assert not end.shutdown.is_over()
    end.clock.now = 2.02 * SHUTDOWN
    assert end.shutdown.is_over()
