"""Recording on real zenoh: by a process of its own, and within the router."""

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import psutil
import pytest

from deploy.processes import table
from deploy.processes.router import listening
from deploy.processes.supervisor import Supervisor
from deploy.recording import process
from deploy.recording.reader import read
from deploy.recording.trajectory import trajectory
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import encode
from protocol.keys import world_key
from protocol.messages import Result, Truth
from tests.deploy.monitor.watched import until
from tests.deploy.recording.fake_world import FakeWorld
from tests.deploy.recording.recorded import ROBOTS, scenario


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
    """Publish until the file holds the present tick, half a second later or when it next grows; that tick."""
    safe = world.tick
    _feed(world, bus, _after(0.5))
    size = path.stat().st_size
    _feed(world, bus, lambda: path.stat().st_size > size)
    return safe


@pytest.fixture
def network():
    """A world on a router, and the endpoint."""
    router, endpoint = listening(Connection("router"))
    with closing(router), closing(ZenohBus(Connection(connect=(endpoint,)))) as bus:
        yield FakeWorld(bus, "lost"), bus, endpoint


def _after(seconds: float) -> Callable[[], bool]:
    due = time.monotonic() + seconds
    return lambda: time.monotonic() > due


def _recorder(endpoint: str, path: Path) -> multiprocessing.Process:
    started = multiprocessing.get_context("spawn").Process(
        target=_record, args=(Connection(connect=(endpoint,)), path), daemon=True
    )
    started.start()
    return started


def _record(connection: Connection, path: Path) -> None:
    raise SystemExit(process.main(connection, "lost", path))


@pytest.mark.process
def test_a_killed_recorder_leaves_all_but_the_last_moment(network, tmp_path):
    world, bus, endpoint = network
    path = tmp_path / "killed.mcap"
    recorder = _recorder(endpoint, path)
    try:
        _feed(world, bus, lambda: path.exists() and path.stat().st_size > 1000)
        safe = _feed_past(world, bus, path)
        os.kill(recorder.pid, signal.SIGKILL)
    finally:
        recorder.kill()
        recorder.join(10)
    found = read(path)
    assert found.cut
    assert found.truths.ticks[-1] > safe, "more than the last second is lost"


@pytest.mark.process
def test_a_recorder_told_to_stop_finishes_with_the_result(network, tmp_path):
    world, bus, endpoint = network
    path = tmp_path / "stopped.mcap"
    recorder = _recorder(endpoint, path)
    try:
        _feed(world, bus, lambda: path.exists() and path.stat().st_size > 1000)
        os.kill(recorder.pid, signal.SIGTERM)
        _feed(world, bus, _after(0.1))
        world.say(world_key("lost", "result"), encode(Result('{"verdict": "interrupted"}')))
        recorder.join(10)
    finally:
        recorder.kill()
    assert recorder.exitcode == 0
    found = read(path)
    assert found.result == {"verdict": "interrupted"}
    assert not found.cut


# -- within the router


def _write_end(router: int) -> int:
    """The process beside a router that writes the file."""
    (writer,) = psutil.Process(router).children()
    return writer.pid


@pytest.fixture
def aboard(tmp_path):
    """A router that records, as a fleet starts it: its process, its endpoint and the file."""
    path = tmp_path / "aboard.mcap"
    with Supervisor() as supervisor:
        supervisor.start([table.router(Connection("router"), ("lost", path))])
        endpoint = supervisor.report("router", 30.0)
        yield supervisor, supervisor.usage()[0].pid, endpoint, path


@pytest.mark.process
@pytest.mark.parametrize("victims", ["writer", "router", "both"])
def test_killed_it_leaves_all_but_the_last_moment(aboard, victims):
    supervisor, router, endpoint, path = aboard
    writer = _write_end(router)
    with closing(ZenohBus(Connection(connect=(endpoint,)))) as bus:
        world = FakeWorld(bus, "lost")
        _feed(world, bus, lambda: path.exists() and path.stat().st_size > 1000)
        safe = _feed_past(world, bus, path)
        for victim in {"writer": [writer], "router": [router], "both": [router, writer]}[victims]:
            os.kill(victim, signal.SIGKILL)
        _feed(world, bus, _after(0.1))
        if victims == "writer":
            assert supervisor.poll() == [], "the fleet can go on"
    until(lambda: not _runs(writer))
    found = read(path)
    assert found.cut
    assert found.truths.ticks[-1] > safe, "more than the last half second is lost"
    assert found.truths.missing == 0


def _runs(pid: int) -> bool:
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


@pytest.mark.process
def test_a_fleet_is_recorded_by_its_router_to_the_last_message(tmp_path):
    path = tmp_path / "fleet.mcap"
    with Fleet([scenario()], RunOptions(), record=path) as fleet:
        (report,) = fleet.execute()
        names = [process["name"] for process in fleet.processes()]
    assert table.RECORDER not in names
    found = read(path)
    assert not found.cut
    assert trajectory(found) == (report["trajectory_sha256"], 0)
    for spec in ROBOTS:
        assert [state.tick for state in found.states[spec.id]] == list(range(report["ticks"]))
        assert [command.tick for command in found.commands[spec.id]] == list(range(report["ticks"]))
