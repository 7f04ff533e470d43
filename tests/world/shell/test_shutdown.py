"""Robots that owe a report, those to be notified, and for how long. There is no bus, and time is injected."""

from protocol.joining import Finished, Join, Reply, Wait
from protocol.messages import Health
from tests.world.driving import Stopwatch, two
from world.shell.admission import Admissions
from world.shell.pacing import Pacing
from world.shell.run import SHUTDOWN, JudgedRun, Phase, Shutdown


class Ending:
    """A turn of two robots that are there."""

    def __init__(self) -> None:
        self.clock = Stopwatch()
        self.turn = JudgedRun(two())
        self.admissions = Admissions("r", self.turn.world, True, self.clock)
        self.shutdown = Shutdown(self.turn, self.admissions, Pacing(True, 0.0, self.clock))
        self.turn.began = 0.0
        for robot in (1, 2):
            self.admissions.enlist(Join(robot, f"session {robot}"))
            self.admissions.arrive(robot, f"session {robot}")

    def ask(self, robot: int, published: int | None = None) -> Reply | None:
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
    assert end.ask(1, published=3) is None
    assert end.admissions.slots[1].health is None  # of a life that ended during the run
    assert not end.shutdown.is_reported()
    assert not end.shutdown.is_over()


def test_all_report_then_all_are_notified() -> None:
    end = Ending()
    end.turn.world.finish("aborted", "for a test")
    end.shutdown.begin()
    assert end.turn.phase is Phase.SHUTDOWN
    assert end.told() == {1, 2}
    assert isinstance(end.ask(1, published=3), Wait)
    assert isinstance(end.ask(1), Wait)  # asks again, and what it said stays
    assert end.told() == {2}
    assert not end.shutdown.is_reported()
    end.ask(2, published=4)
    assert end.shutdown.is_reported()
    end.clock.now = 1.5
    report = end.shutdown.report(10)
    assert report["messages"]["published"] == 17
    assert report["wall_time"] == 0.0  # up to the verdict
    end.shutdown.close()
    assert not end.shutdown.is_reported()
    assert end.told() == {1, 2}
    assert end.ask(1) == Finished("aborted")
    assert end.told() == {2}
    assert not end.shutdown.is_over()
    assert end.ask(2) == Finished("aborted")
    assert end.shutdown.is_over()


def test_no_process_waits_for_one_that_has_gone() -> None:
    end = Ending()
    end.shutdown.begin()
    end.ask(1, published=3)
    end.admissions.leave(2)
    assert end.shutdown.is_reported()
    end.shutdown.close()
    end.ask(1)
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
