"""The recorder: what it records and refuses, when it ends, and what is left when it is killed."""

import json
import signal
import time
from collections.abc import Callable
from contextlib import closing, suppress
from functools import partial
from pathlib import Path

import msgspec
import numpy as np
import pytest
from mcap.reader import make_reader

from deploy.processes import table
from deploy.processes.router import listening
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from deploy.telemetry.recording.reader import read
from deploy.telemetry.recording.recorder import PATIENCE, Recorder
from deploy.telemetry.recording.replay import trajectory
from deploy.telemetry.recording.writer import RecordingWriter
from protocol import joining
from protocol.bus.connection import Connection
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.bus.zenoh import ZenohBus
from protocol.codec import encode
from protocol.errors import BusError, RecordingError
from protocol.keys import everything, robot_key, world_key
from protocol.messages import Clock, Command, Result, State, Truth
from protocol.streams import STREAMS
from tests.deploy.telemetry.recording.fake_world import FakeWorld
from tests.deploy.telemetry.recording.recorded import ROBOTS, said_by, scenario


def _recorder(bus: LocalBus, run: str, folder: Path) -> tuple[Recorder, RecordingWriter]:
    bus.subscribe(everything(run))
    file = RecordingWriter(folder / f"{run}.mcap")
    recorder = bus.node = Recorder(bus, run, file)
    return recorder, file


def test_what_is_no_message_of_the_run_is_counted_not_recorded(tmp_path):
    network = LocalNetwork()
    world = FakeWorld(network.connect(), "fake")
    recorder, file = _recorder(network.connect(), "fake", tmp_path)
    command = Command(1, 1, 0, (0.1, 0.2))
    good, foreign = robot_key("fake", 1, "command"), robot_key("fake", 5, "command")
    for key, payload in (
        (good, encode(command)),
        (good, b"\x93"),
        (good, encode(msgspec.structs.replace(command, velocity=(float("nan"), 0.0)))),
        (good, encode(msgspec.structs.replace(command, robot=2))),
        (foreign, encode(msgspec.structs.replace(command, robot=5))),
        (good, bytes(STREAMS["command"].limit + 1)),
    ):
        world.say(key, payload)
    world.say(world_key("fake", "result"), encode(Result('{"verdict": "arrived"}')))
    network.run(lambda: recorder.finished)
    file.finish(recorder.result)
    found = read(tmp_path / "fake.mcap")
    assert [entry.message for entry in found.entries] == [command]
    assert found.result == {"verdict": "arrived"}
    with (tmp_path / "fake.mcap").open("rb") as file:
        metadata = {each.name: each.metadata for each in make_reader(file).iter_metadata()}
    assert json.loads(metadata["recorder"]["rejected"]) == {
        "shape": 2,
        "identity": 1,
        "key": 1,
        "oversize": 1,
    }


def test_a_world_that_never_appears_ends_the_wait(tmp_path):
    bus = LocalNetwork().connect()
    recorder = Recorder(bus, "r", RecordingWriter(tmp_path / "x.mcap"), patience=0.01)
    assert recorder.deadline < time.monotonic() + 0.02
    with pytest.raises(BusError, match="no world to record within"):
        recorder.wake(recorder.deadline)


def test_the_end_of_the_world_ends_the_recording(tmp_path):
    network = LocalNetwork()
    bus = network.connect()
    world = FakeWorld(bus, "gone")
    listener = network.connect()
    recorder, file = _recorder(listener, "gone", tmp_path)
    recorder.handle(listener.receive(0.0))
    world.say(robot_key("gone", 1, "command"), encode(Command(1, 1, 0, (0.1, 0.2))))
    bus.close()
    network.run(lambda: recorder.finished)
    file.finish()
    found = read(tmp_path / "gone.mcap")
    assert (found.counts.total(), found.result, found.cut) == (1, None, False)


@pytest.mark.parametrize(
    "first", [b"\xc1", joining.encode_reply(joining.Wait(1.0))], ids=["malformed", "another"]
)
def test_a_world_that_answers_nonsense_is_asked_again(tmp_path, first):
    network = LocalNetwork()
    world = FakeWorld(network.connect(), "odd")
    world.replies = [first]
    recorder, file = _recorder(network.connect(), "odd", tmp_path)
    network.run(lambda: not world.replies)
    world.say(robot_key("odd", 1, "command"), encode(Command(1, 1, 0, (0.1, 0.2))))
    recorder.wake(recorder.deadline)
    recorder.close()
    file.finish()
    assert said_by(read(tmp_path / "odd.mcap"), Command, 1) == [Command(1, 1, 0, (0.1, 0.2))]


def test_a_world_that_answers_nothing_else_is_named(tmp_path):
    network = LocalNetwork()
    FakeWorld(network.connect(), "odd").replies = [b"\xc1"] * 2
    recorder, _ = _recorder(network.connect(), "odd", tmp_path)
    recorder.handle(recorder._bus.receive(0.0))
    with pytest.raises(BusError, match="the world does not send its scenario within"):
        recorder.wake(time.monotonic() + PATIENCE)


# -- as a process


def _feed(world: FakeWorld, bus: ZenohBus, until: Callable[[], object]) -> None:
    """Publish truths, up to a thousand a second, until told."""
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


def _feed_past(world: FakeWorld, bus: ZenohBus, path: Path) -> int:
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


class Process:
    """A recorder beside a router and a world, as a fleet starts it."""

    def __init__(
        self, supervisor: Supervisor, world: FakeWorld, bus: ZenohBus, row: Callable[..., table.Process]
    ) -> None:
        self.supervisor, self._world, self._bus = supervisor, world, bus
        supervisor.start([row(again=False)])
        self.heard: list[str] = []
        self.feed(lambda: self.named)
        supervisor.amend(row(again=True))
        self.path = Path(self.heard[0])

    @property
    def named(self) -> list[str]:
        """The files that it has reported since it was last asked."""
        self.supervisor.poll()
        named = self.supervisor.heard(table.RECORDER)
        self.heard += named
        return named

    def feed(self, until: Callable[[], object]) -> None:
        _feed(self._world, self._bus, until)

    def feed_past(self, path: Path) -> int:
        return _feed_past(self._world, self._bus, path)


@pytest.fixture
def process(tmp_path):
    router, endpoint = listening(Connection("router"))
    connection = Connection(connect=(endpoint,))
    with closing(router), closing(ZenohBus(connection)) as bus, Supervisor() as supervisor:
        world = FakeWorld(bus, "lost")
        result = tmp_path / "result.json"
        row = partial(
            table.recorder, connection, "lost", tmp_path / "run.mcap", result, away=30.0, restarts=1
        )
        yield Process(supervisor, world, bus, row)


@pytest.mark.process
def test_killed_it_leaves_all_but_the_last_moment_and_the_next_writes_another_file(process, tmp_path):
    path, result = tmp_path / "run.mcap", tmp_path / "result.json"
    safe = process.feed_past(path)
    process.supervisor.signal(table.RECORDER, signal.SIGKILL)
    process.feed(lambda: process.named)
    more = tmp_path / "run-2.mcap"
    assert process.heard == [str(path), str(more)]
    last = process.feed_past(more)
    result.write_text('{"verdict": "interrupted"}')
    process.supervisor.stop()
    before, after = read(path), read(more)
    assert before.cut
    assert before.truths.ticks[-1] >= safe
    assert np.diff(before.truths.ticks[1:]).max() == 1
    assert (after.cut, after.result) == (False, {"verdict": "interrupted"})
    assert last in after.truths.ticks


@pytest.mark.process
def test_told_to_stop_before_there_is_a_world_it_leaves_no_file(tmp_path):
    router, endpoint = listening(Connection("router"))
    with closing(router), Supervisor() as supervisor:
        connection = Connection(connect=(endpoint,))
        supervisor.start(
            [table.recorder(connection, "none", tmp_path / "run.mcap", tmp_path / "result.json")]
        )
        supervisor.stop()
        (usage,) = supervisor.usage()
    assert usage.exit_code == 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.process
def test_a_fleet_is_recorded_to_the_last_message(tmp_path):
    path = tmp_path / "fleet.mcap"
    with Fleet(scenario(), RunOptions(), record=path) as fleet:
        report = fleet.execute()
        fleet.processes()
        fleet.record(report | {"transport": "routed"})
        assert fleet.recordings() == [str(path)]
    found = read(path)
    assert (found.cut, found.result) == (False, report | {"transport": "routed"})
    assert trajectory(found) == (report["trajectory_sha256"], 0)
    for spec in ROBOTS:
        assert [state.tick for state in said_by(found, State, spec.id)] == list(range(report["ticks"]))
        assert [command.tick for command in said_by(found, Command, spec.id)] == list(range(report["ticks"]))


@pytest.mark.process
def test_a_fleet_whose_recorder_is_killed_goes_on_without_it(tmp_path, caplog):
    path = tmp_path / "fleet.mcap"

    def kill(clock: Clock) -> None:
        if clock.tick > 5 and table.RECORDER in fleet.pids():
            fleet.signal(table.RECORDER, signal.SIGKILL)

    with Fleet(scenario(), RunOptions(speed=5.0), watch=kill, record=path) as fleet:
        report = fleet.execute()
        fleet.processes()
        with pytest.raises(RecordingError, match=r"fleet\.mcap was not finished: its recorder ended with"):
            fleet.record(report)
    assert report["verdict"] == "arrived"
    assert "the recording ends there" in caplog.text
    assert read(path).cut
