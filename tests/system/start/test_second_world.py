"""Two worlds of one run as real processes: one is refused, requests reach all that answer, and both stand."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from deploy.library.load import load
from deploy.processes import table
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.operator import Operator, operating
from deploy.run.options import RunOptions, fresh_run_name
from protocol.bus.connection import Connection
from protocol.errors import RunTakenError
from protocol.scenario.model import Journey, Operation
from tests.forks import Forks
from tests.until import until
from world.process import REFUSED

pytestmark = [pytest.mark.process, pytest.mark.timeout(120)]

SCENARIO = load("swap-2", ["time.endless=true"])
ASIDE = Operation(goal=Journey(1, ((0.1, 0.1), (-0.1, 0.1)), patrol=True))
RELEASE = Operation(halt=False)


def router(supervisor: Supervisor, *others: str) -> Connection:
    supervisor.start([table.router(Connection("router", connect=others))])
    return Connection(connect=(supervisor.report("router", 20.0),))


@contextmanager
def driving(supervisor: Supervisor, connection: Connection, run: str) -> Iterator[Operator]:
    """A fleet that goes round and round, and its operator."""
    robots = [table.robot(connection, run, robot) for robot in SCENARIO.ids]
    supervisor.start([table.world(connection, run, SCENARIO, True, speed=2.0), *robots])
    with operating(run, connection.connect[0]) as operator:
        operator.wait_for_begin(30.0)
        assert operator.operate(ASIDE).accepted
        yield operator


def test_a_second_world_is_refused_and_stops_reach_the_first(
    disknav: Forks, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    run = fresh_run_name()
    with Supervisor() as supervisor, Supervisor() as others:
        connection = router(supervisor)
        with driving(supervisor, connection, run) as operator:
            others.start([table.Process("other", "world.process:main", (connection, run, SCENARIO, True))])
            while not (exits := others.poll(0.01)):
                stopped = operator.stop(10.0)
                assert (stopped.halted, stopped.moving) == (True, ())
                assert operator.operate().halted
                assert not operator.operate(RELEASE).halted
            assert [exit_.code for exit_ in exits] == [REFUSED]
            at, call = connection.connect[0], ("run", "swap-2", "--run", run)
            done, kept = disknav(*call, "--router", at), disknav(*call, "--keep", "--listen", at)
            options = RunOptions(router=at, run=run, restarts=9)
            monkeypatch.setattr("deploy.run.assembly.look_for_others", lambda *_: None)  # it came meanwhile
            with pytest.raises(RunTakenError), Fleet(SCENARIO, options) as fleet:
                fleet.execute()
            assert not operator.operate().halted
            assert supervisor.running() == ["router", "world", "robot-1", "robot-2"]
    text = f"another world of run {run!r} is on this network: end that one first"
    assert capfd.readouterr().err.count(text) == 2  # of `other`, and of the fleet's world
    assert (done.returncode, len(done.stderr.splitlines()), kept.returncode) == (2, 1, 2)
    assert text in done.stderr


def test_fleets_on_joined_networks_stand_until_one_has_left(caplog: pytest.LogCaptureFixture) -> None:
    run = fresh_run_name()
    with Supervisor() as first, Supervisor() as second, Supervisor() as link:
        here, there = router(first), router(second)
        with driving(first, here, run) as operator, driving(second, there, run):
            router(link, *here.connect, *there.connect)
            until(lambda: operator.operate().halted and f"2 worlds of run {run!r}" in caplog.text)
            assert operator.operate(RELEASE).text.startswith("another world of this run")
            assert operator.operate().halted
            second.stop()
            until(lambda: not operator.operate().halted)
