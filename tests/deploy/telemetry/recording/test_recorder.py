"""The recorder: what it writes, what it refuses, and when it ends."""

import json
import os
import time
from pathlib import Path

import msgspec
import pytest
from mcap.reader import make_reader

from deploy.telemetry.recording.reading.reader import read
from deploy.telemetry.recording.recorder import PATIENCE, Recorder
from deploy.telemetry.recording.writer import RecordingFile
from deploy.telemetry.recording.writer_process import WriterProcess
from protocol import joining
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.codec import encode
from protocol.errors import BusError, RecordingError, UsageError
from protocol.keys import everything, robot_key, world_key
from protocol.messages import Command, Health, Result
from protocol.streams import STREAMS
from tests.deploy.telemetry.recording.fake_world import FakeWorld
from tests.deploy.telemetry.recording.recorded import said_by, scenario


def _recorder(bus: LocalBus, run: str, folder: Path) -> tuple[Recorder, RecordingFile]:
    bus.subscribe(everything(run))
    file = RecordingFile(folder / f"{run}.mcap")
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
    file.finish()
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


def test_the_good_messages_of_a_batch_are_kept_in_order(tmp_path):
    file = RecordingFile(tmp_path / "x.mcap")
    file.begin("r", scenario())
    key = robot_key("r", 1, "command")
    good = [Command(1, 1, tick, (0.1, float(tick))) for tick in range(2000)]
    bad = encode(Command(1, 1, 0, (0.1, float("inf")))), encode(Command(2, 1, 0, (0.1, 0.2))), b"\x93"
    batch = []
    for command in good:
        batch.append((key, encode(command)))
        batch.append((key, bad[command.tick % 3]))
    note = encode(Health(1, 1, 3, 0.0, 1, 1, {}, (), (), "null"))
    batch.append((robot_key("r", 1, "health"), note))  # a word, and no number
    file.write(batch)
    file.finish()
    found = read(tmp_path / "x.mcap")
    assert said_by(found, Command, 1) == good
    assert [each.note for each in said_by(found, Health, 1)] == ["null"]
    assert file.rejected == {"shape": 1333, "identity": 667}


def test_a_tick_beyond_all_time_does_not_end_the_recording(tmp_path):
    file = RecordingFile(tmp_path / "x.mcap")
    file.begin("r", scenario())
    file.write([(robot_key("r", 1, "command"), encode(Command(1, 1, 2**53, (0.1, 0.2))))])
    file.finish()
    assert said_by(read(tmp_path / "x.mcap"), Command, 1) == [Command(1, 1, 2**53, (0.1, 0.2))]


def test_a_chunk_without_messages_is_whole(tmp_path):
    file = RecordingFile(tmp_path / "x.mcap")
    file.begin("r", scenario())
    file.write([(robot_key("r", 1, "command"), b"\x93")])
    file.flush()
    file.finish()
    found = read(tmp_path / "x.mcap")
    assert (list(found.entries), found.cut) == ([], False)


def test_a_file_that_cannot_be_created_is_refused_at_once(tmp_path):
    with pytest.raises(UsageError, match=r"cannot record to .*x\.mcap"):
        RecordingFile(tmp_path / "no" / "x.mcap")


def test_the_same_when_another_process_writes(tmp_path):
    with pytest.raises(UsageError, match=r"cannot record to .*x\.mcap"):
        WriterProcess(tmp_path / "no" / "x.mcap")
    here, beside = RecordingFile(tmp_path / "here.mcap"), WriterProcess(tmp_path / "beside.mcap")
    for file in (here, beside):
        file.begin("r", scenario())
        file.write([(robot_key("r", 1, "command"), encode(Command(1, 1, 0, (0.1, 0.2))))])
        file.flush()
        file.finish('{"verdict": "arrived"}')
    assert (tmp_path / "here.mcap").read_bytes() == (tmp_path / "beside.mcap").read_bytes()


def test_the_end_of_the_process_that_writes_is_an_error(tmp_path):
    file = WriterProcess(tmp_path / "x.mcap")
    child = file._process
    child.kill()
    child.join(10)
    with pytest.raises(RecordingError, match=r"cannot go on recording to .*x\.mcap"):
        file.begin("r", scenario())


@pytest.mark.parametrize("more", [b"", b"\0\0\4\0half a message"], ids=["", "in the middle of a message"])
def test_the_end_of_who_tells_ends_the_file_with_all_that_was_told(tmp_path, more):
    file = WriterProcess(tmp_path / "x.mcap")
    file.begin("r", scenario())
    file.write([(robot_key("r", 1, "command"), encode(Command(1, 1, 0, (0.1, 0.2))))])
    os.write(file._pipe.fileno(), more)
    file.close()
    found = read(tmp_path / "x.mcap")
    assert said_by(found, Command, 1) == [Command(1, 1, 0, (0.1, 0.2))]
    assert (found.result, found.cut) == (None, True)
    with (tmp_path / "x.mcap").open("rb") as stream:
        assert make_reader(stream).get_summary() is not None


def test_a_world_that_never_appears_ends_the_wait(tmp_path):
    bus = LocalNetwork().connect()
    recorder = Recorder(bus, "r", RecordingFile(tmp_path / "x.mcap"), patience=0.01)
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
