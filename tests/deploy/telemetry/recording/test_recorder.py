"""The recorder: what it records and refuses, when it ends, and what is left when it is killed."""

import json
from contextlib import nullcontext
from pathlib import Path

import msgspec
import pytest
from mcap.reader import make_reader

from deploy.processes import table
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from deploy.telemetry.recording.reader import read
from deploy.telemetry.recording.recorder import Recorder, awaited_scenario
from deploy.telemetry.recording.writer import RecordingWriter
from protocol import joining
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.codec import encode
from protocol.errors import BusError, RecordingError
from protocol.keys import STREAMS, everything, robot_key, world_key
from protocol.messages import Clock, Command, Result
from tests.deploy.telemetry.recording.recorded import FakeWorld, scenario


def _recorder(bus: LocalBus, run: str, folder: Path) -> Recorder:
    bus.subscribe(everything(run))
    recorder = bus.node = Recorder(bus, run, RecordingWriter(folder / f"{run}.mcap", run, scenario()))
    return recorder


def test_what_is_no_message_of_the_run_is_counted_not_recorded(tmp_path):
    network = LocalNetwork()
    world = FakeWorld(network.connect(), "fake")
    recorder = _recorder(network.connect(), "fake", tmp_path)
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
    recorder.finish()
    found = read(tmp_path / "fake.mcap")
    assert [entry.message for entry in found.entries] == [command]
    assert found.result == {"verdict": "arrived"}
    with (tmp_path / "fake.mcap").open("rb") as file:
        metadata = {each.name: each.metadata for each in make_reader(file).iter_metadata()}
    rejected = json.loads(metadata["recorder"]["rejected"])
    assert rejected == {"shape": 2, "identity": 1, "key": 1, "oversize": 1}


def test_a_world_that_never_appears_ends_the_wait():
    with pytest.raises(BusError, match="no world has sent its scenario within"):
        awaited_scenario(LocalNetwork().connect(), "r", 0.0)


def test_the_end_of_the_world_ends_the_recording(tmp_path):
    network = LocalNetwork()
    bus = network.connect()
    world = FakeWorld(bus, "gone")
    listener = network.connect()
    recorder = _recorder(listener, "gone", tmp_path)
    recorder.handle(listener.receive(0.0))
    world.say(robot_key("gone", 1, "command"), encode(Command(1, 1, 0, (0.1, 0.2))))
    bus.close()
    network.run(lambda: recorder.finished)
    recorder.finish()
    found = read(tmp_path / "gone.mcap")
    assert (found.counts.total(), found.result, found.cut) == (1, None, False)


@pytest.mark.parametrize(
    "first", [b"\xc1", joining.encode_reply(joining.Wait(1.0))], ids=["malformed", "another"]
)
def test_a_world_that_answers_nonsense_is_asked_again(first):
    network = LocalNetwork()
    FakeWorld(network.connect(), "odd").replies = [first]
    assert awaited_scenario(network.connect(), "odd") == scenario()


# -- as a process


@pytest.mark.process
@pytest.mark.parametrize(("restarts", "number"), [(0, 9), (1, 9), (0, 15)])
def test_a_fleet_whose_recorder_is_killed_goes_on(restarts, number, tmp_path, caplog):
    """Without it, or with the next one, which writes another file; the first is read to its end."""
    path, more, killed = tmp_path / "fleet.mcap", tmp_path / "fleet-2.mcap", list[int]()

    def kill(clock: Clock) -> None:
        if clock.tick > (25 if number == 9 else 0) and not killed:  # asked to end, it waits for the result
            killed.append(clock.tick)
            fleet.supervisor.signal(table.RECORDER, number)

    options = RunOptions(speed=0.7, restarts=restarts)  # the next one takes a while, and so does a result
    with Fleet(scenario(), options, watch=kill, record=path) as fleet:
        report = fleet.execute()
        fleet.processes()
        said, failed = r"fleet\.mcap is incomplete: its recorder ended with", number == 9 and not restarts
        with pytest.raises(RecordingError, match=said) if failed else nullcontext():
            fleet.record(report)
        assert fleet.recordings() == [str(path), str(more)][: 1 + restarts]
        assert restarts or "the recording ends there" in caplog.text
    assert report["verdict"] == "arrived"
    before = read(path)
    assert (before.cut, before.result) == (number == 9, None)
    assert before.trajectory.missing == 0
    assert before.trajectory.ticks[-1] > 0
    if restarts:
        after = read(more)
        assert (after.cut, after.result) == (False, report)
        assert after.trajectory.ticks[-1] == report["ticks"]
