"""A supervisor and its processes: what each end means, waits between failures, and nothing left behind."""

import signal
from collections.abc import Iterator
from unittest.mock import Mock

import pytest

from deploy.processes.spawn import Process, Spawner
from deploy.processes.supervisor import STEADY, Exit, ProcessLife, Supervisor
from protocol.errors import ProcessError, StartError
from tests.deploy.processes import children
from tests.deploy.processes.children import give, row, spawner, wait
from tests.until import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(60)]

PATIENCE = 20.0  # s


@pytest.fixture
def supervisor() -> Iterator[Supervisor]:
    with Supervisor(spawner()) as supervisor:
        yield supervisor


def waiting(name: str) -> Process:
    return row(name, wait, reports=True)


def exits(supervisor: Supervisor, number: int) -> list[Exit]:
    heard: list[Exit] = []
    until(lambda: heard.extend(supervisor.poll(0.1)) or len(heard) >= number, PATIENCE)
    return heard


def test_exits_are_noticed_and_judged(supervisor: Supervisor) -> None:
    mortal = row("killed", wait, reports=True, restarts=1)
    supervisor.start([row("good", give, 0), row("bad", give, 2), mortal, waiting("lost")])
    supervisor.report("killed", PATIENCE)
    supervisor.report("lost", PATIENCE)
    supervisor.signal("killed", signal.SIGKILL)  # as if by accident
    supervisor.signal("lost", signal.SIGKILL)
    supervisor.kill("killed", gently=True)  # it is dead already
    seen = {exit_.process.name: (exit_.code, exit_.expected) for exit_ in exits(supervisor, 4)}
    assert seen == {"good": (0, True), "bad": (2, False), "killed": (-9, True), "lost": (-9, False)}
    assert supervisor.running() == []


def test_a_lost_host_ends_its_own_rows_only() -> None:
    there = spawner()
    with Supervisor(spawner(), {"left": there}, {"far": "left"}) as supervisor:
        supervisor.start([waiting("near"), row("far", wait, reports=True, restarts=9)])
        supervisor.report("far", PATIENCE)
        there._server.kill()
        (lost,) = exits(supervisor, 1)
        assert (lost.process.name, lost.expected, supervisor.running()) == ("far", False, ["near"])
        assert not lost.again, "nothing starts on a lost host, however many restarts are left"
        assert str(lost).startswith("far: the fork server")
        supervisor.restart("far")
        (vain,) = exits(supervisor, 1)
        assert str(vain) == "far: this host is lost"
        supervisor.report("near", PATIENCE)
        supervisor.signal("near", signal.SIGKILL)
        assert str(exits(supervisor, 1)[0]) == "near: killed by SIGKILL"


def test_a_host_that_reports_what_it_was_not_asked_for_is_lost() -> None:
    there = spawner()
    with Supervisor(spawner(), {"left": there}) as supervisor:
        there.start(row("foreign", give, 0))
        supervisor.start([waiting("near")])
        supervisor.report("near", PATIENCE)
        until(lambda: supervisor.poll(0.1) or there.gone, PATIENCE)
        assert supervisor.running() == ["near"]


def test_a_failing_process_is_restarted_as_often_as_its_row_says(supervisor: Supervisor) -> None:
    supervisor.start([row("again", give, 1, restarts=2)])
    supervisor.up(["again"])
    assert ([exit_.code for exit_ in exits(supervisor, 3)], supervisor.running()) == ([1, 1, 1], [])
    assert supervisor.usage()[0].restarts == 2


def test_a_process_that_could_not_start_is_not_started_again(supervisor: Supervisor) -> None:
    """Its second try would end as the first; one that is killed as it starts is another matter, and so is
    its successor, as of a world whose place another one takes meanwhile."""
    supervisor.start([row("vain", give, 3, restarts=1000, reports=True)])
    with pytest.raises(StartError, match="vain could not start"):
        supervisor.report("vain", PATIENCE)
    for status, name in (2, "killed"), (4, "last"):
        supervisor.start([row(name, wait, restarts=2)])
        supervisor.amend(row(name, give, status, restarts=2))
        supervisor.signal(name, signal.SIGKILL)
    seen = sorted((exit_.code, exit_.again) for exit_ in exits(supervisor, 6))
    assert seen == [(-9, True), (-9, True), (2, False), (2, True), (3, False), (4, False)]


def test_restart_replaces_a_process(supervisor: Supervisor) -> None:
    supervisor.start([waiting("one")])
    supervisor.report("one", PATIENCE)
    first = supervisor.usage()[0].pid
    supervisor.restart("one")
    assert supervisor.report("one", PATIENCE) == "waiting"
    (usage,) = supervisor.usage()
    assert (usage.restarts, usage.exit_code) == (1, None)
    assert usage.pid != first
    supervisor.kill("one")
    exits(supervisor, 2)
    supervisor.restart("one")
    assert supervisor.report("one", PATIENCE) == "waiting"


def test_stopping_wakes_a_frozen_process_and_kills_a_stubborn_one(supervisor: Supervisor) -> None:
    supervisor.start(
        [
            waiting("plain"),
            waiting("frozen"),
            row("stubborn", children.wait_stubbornly, reports=True, patience=1.0),
        ]
    )
    for name in ("plain", "frozen", "stubborn"):
        supervisor.report(name, PATIENCE)
    supervisor.pause("frozen")
    supervisor._here._server.send_signal(signal.SIGSTOP)  # the fork server
    supervisor.stop()
    codes = {usage.name: usage.exit_code for usage in supervisor.usage()}
    assert codes == {"plain": 0, "frozen": 0, "stubborn": -9}


def test_a_process_that_says_nothing_is_named(supervisor: Supervisor) -> None:
    supervisor.start([row("mute", wait), row("broken", children.divide_by_zero, reports=True)])
    with pytest.raises(ProcessError, match=r"mute did not answer within 0\.05 s"):
        supervisor.report("mute", 0.05)
    with pytest.raises(ProcessError, match="broken could not start"):
        supervisor.report("broken", PATIENCE)


def test_a_process_that_dies_in_the_middle_of_a_report_dies_alone(supervisor: Supervisor) -> None:
    supervisor.start([waiting("well"), row("torn", children.die_while_reporting, reports=True)])
    (exit_,) = exits(supervisor, 1)
    assert (exit_.process.name, exit_.code) == ("torn", -signal.SIGKILL)
    assert supervisor.heard("torn") == []
    with pytest.raises(ProcessError, match="torn: killed by SIGKILL before it had started"):
        supervisor.report("torn", PATIENCE)
    assert supervisor.report("well", PATIENCE) == "waiting"
    supervisor.restart("well")
    assert supervisor.report("well", PATIENCE) == "waiting"


def test_waits_grow_to_a_cap_and_begin_anew_after_a_steady_life() -> None:
    life = ProcessLife(Process("sick", "module:main"), Mock(spec=Spawner))
    waits = [life.wait(1.0) for _ in range(10)]
    assert waits == [0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 10.0, 10.0, 10.0]
    assert life.wait(STEADY) == 0.0
    assert life.wait(STEADY - 0.1) == 0.25
    assert [life.wait(0.0) for _ in range(5000)][-1] == 10.0


def test_one_that_keeps_dying_starves_no_other(supervisor: Supervisor) -> None:
    """Its next life waits; that of another does not, and what was told to stop is not started again."""
    supervisor.start([row("sick", give, 3, restarts=1000), waiting("sound")])
    supervisor.up(["sick"])
    supervisor.report("sound", PATIENCE)
    exits(supervisor, 4)
    supervisor.restart("sound")
    assert supervisor.report("sound", PATIENCE) == "waiting"
    supervisor.stop()
    assert supervisor.running() == []
    list(supervisor.poll(0.5))
    assert supervisor.running() == []
