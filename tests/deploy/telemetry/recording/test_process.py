"""Recording on real zenoh: by a process of its own, and within the router."""

import signal
import time
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path

import pytest

from deploy.processes import table
from deploy.processes.router import listening
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from deploy.telemetry.recording.reading.reader import read
from deploy.telemetry.recording.reading.trajectory import trajectory
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import encode
from protocol.errors import RecordingError
from protocol.keys import world_key
from protocol.messages import Command, Result, State, Truth
from tests.deploy.telemetry.monitor.watched import until
from tests.deploy.telemetry.recording.fake_world import FakeWorld
from tests.deploy.telemetry.recording.recorded import ROBOTS, said_by, scenario


def _feed(world: FakeWorld, bus, until: Callable[[], bool]) -> int:
    """Publish truths, up to a thousand a second, until told; returns the last tick."""
    positions = tuple(spec.start for spec in ROBOTS)
    robots = tuple(spec.id for spec in ROBOTS)
    deadline = time.monotonic() + 60.0
    while not until():
        assert time.monotonic() < deadline, "the recorder does not record"
        world.tick += 1
        event = bus.receive(0.001)
        if event is not None:
            world.handle(event)
        world.say(world_key("lost", "truth"), encode(Truth(world.tick, robots, positions, 0.1, 0.5)))
    return world.tick


def _feed_past(world: FakeWorld, bus, path: Path) -> int:
    """Publish until the file holds the present tick, and beyond; that tick."""
    safe, size = world.tick, 0

    def held() -> bool:
        nonlocal size
        before, size = size, path.stat().st_size if path.exists() else 0
        with suppress(RecordingError):  # it has not begun
            return size > before and read(path).truths.ticks[-1] > safe
        return False

    _feed(world, bus, held)
    return safe


@pytest.fixture
def network():
    """A world on a router, and the endpoint."""
    router, endpoint = listening(Connection("router"))
    with closing(router), closing(ZenohBus(Connection(connect=(endpoint,)))) as bus:
        yield FakeWorld(bus, "lost"), bus, endpoint


@pytest.fixture
def beside(network, tmp_path):
    """A recorder beside a router, and who writes, as a fleet starts them; each may come back once."""
    world, bus, endpoint = network
    path = tmp_path / "beside.mcap"
    with Supervisor() as supervisor:
        supervisor.start([table.writer(path, tmp_path / "writer", restarts=1)])
        supervisor.report(table.WRITER, 30.0)
        connection = Connection(connect=(endpoint,))
        supervisor.start([table.recorder(connection, "lost", tmp_path / "writer", 30.0, restarts=1)])
        _feed_past(world, bus, path)
        yield supervisor, world, bus, path


def _pids(supervisor: Supervisor) -> dict[str, int]:
    """Of those that run now."""
    supervisor.poll()
    return supervisor.pids()


@pytest.mark.process
def test_a_killed_recorder_comes_back_and_the_file_goes_on(beside):
    supervisor, world, bus, path = beside
    safe = _feed_past(world, bus, path)
    _feed(world, bus, lambda: _pids(supervisor) and supervisor.heard(table.RECORDER))
    supervisor.signal(table.RECORDER, signal.SIGKILL)
    _feed(world, bus, lambda: _pids(supervisor) and supervisor.heard(table.RECORDER))
    last = _feed_past(world, bus, path)
    supervisor.stop()
    found = read(path)
    assert not found.cut
    assert {safe, last} <= set(found.truths.ticks.tolist())
    assert list(path.parent.glob("*.mcap")) == [path]


@pytest.mark.process
def test_a_killed_writer_leaves_all_but_the_last_moment_and_the_next_writes_another_file(beside):
    supervisor, world, bus, path = beside
    safe, more = _feed_past(world, bus, path), path.with_stem("beside-2")
    supervisor.signal(table.WRITER, signal.SIGKILL)
    _feed(world, bus, lambda: _pids(supervisor) and more.exists())  # the next one is started meanwhile
    last = _feed_past(world, bus, more)
    world.say(world_key("lost", "result"), encode(Result('{"verdict": "interrupted"}')))
    _feed(world, bus, lambda: table.RECORDER not in _pids(supervisor))  # it has heard that the run is over
    supervisor.stop()
    before, after = read(path), read(more)
    assert before.cut
    assert before.truths.ticks[-1] >= safe
    assert (after.cut, after.result) == (False, {"verdict": "interrupted"})
    assert last in after.truths.ticks
    assert after.truths.ticks[1] <= before.truths.ticks[-1] + 5000, "what was heard meanwhile is handed over"
    assert supervisor.heard(table.WRITER) == [str(path), str(more)]


@pytest.mark.process
def test_a_recorder_told_to_stop_finishes_with_the_result(beside):
    supervisor, world, bus, path = beside
    supervisor.signal(table.RECORDER, signal.SIGTERM)
    told = time.monotonic()
    _feed(world, bus, lambda: time.monotonic() > told + 0.5)  # it waits for the result meanwhile
    world.say(world_key("lost", "result"), encode(Result('{"verdict": "interrupted"}')))
    until(lambda: table.RECORDER not in _pids(supervisor))
    supervisor.stop()
    found = read(path)
    assert found.result == {"verdict": "interrupted"}
    assert not found.cut


# -- within the router


@pytest.fixture
def aboard(tmp_path):
    """A router that records, as a fleet starts it, and the file."""
    path = tmp_path / "aboard.mcap"
    with Supervisor() as supervisor:
        supervisor.start([table.writer(path, tmp_path / "writer")])
        supervisor.report(table.WRITER, 30.0)
        supervisor.start([table.router(Connection("router"), ("lost", tmp_path / "writer"))])
        endpoint = supervisor.report(table.ROUTER, 30.0)
        yield supervisor, endpoint, path


@pytest.mark.process
@pytest.mark.parametrize("victims", [[table.WRITER], [table.ROUTER], [table.ROUTER, table.WRITER]])
def test_killed_it_leaves_all_but_the_last_moment(aboard, victims):
    supervisor, endpoint, path = aboard
    with closing(ZenohBus(Connection(connect=(endpoint,)))) as bus:
        world = FakeWorld(bus, "lost")
        safe = _feed_past(world, bus, path)
        for victim in victims:
            supervisor.signal(victim, signal.SIGKILL)
        _feed(world, bus, lambda: not _pids(supervisor).keys() & set(victims))
    assert _pids(supervisor).keys() == {table.WRITER, table.ROUTER} - set(victims), "the others go on"
    found = until(lambda: found if (found := read(path)).truths.ticks[-1] > safe else None)
    assert found.cut
    assert found.truths.missing == 0


@pytest.mark.process
def test_a_fleet_is_recorded_by_its_router_to_the_last_message(tmp_path):
    path = tmp_path / "fleet.mcap"
    with Fleet(scenario(), RunOptions(), record=path) as fleet:
        report = fleet.execute()
        names = [process["name"] for process in fleet.processes()]
    assert table.RECORDER not in names
    found = read(path)
    assert not found.cut
    assert trajectory(found) == (report["trajectory_sha256"], 0)
    for spec in ROBOTS:
        assert [state.tick for state in said_by(found, State, spec.id)] == list(range(report["ticks"]))
        assert [command.tick for command in said_by(found, Command, spec.id)] == list(range(report["ticks"]))
