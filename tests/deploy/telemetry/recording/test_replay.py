"""Replaying: the same trajectory recomputed, the same messages over again, and what `info` says."""

import time
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer

from deploy.cli.recording import info, replay
from deploy.processes.router import listening
from deploy.telemetry.recording.reader import Contents, RecordedRun, Truths, read
from deploy.telemetry.recording.replay import publish, published, verify
from protocol.bus.bus import Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode, encode
from protocol.errors import RecordingError
from protocol.keys import everything
from protocol.messages import Message, Result, Tick
from tests.deploy.telemetry.recording.recorded import record


@pytest.fixture(scope="module")
def path(tmp_path_factory) -> Path:
    found = tmp_path_factory.mktemp("replay") / "three.mcap"
    record(found)
    return found


@pytest.fixture(scope="module")
def recording(path) -> RecordedRun:
    return read(path)


def _altered(path: Path, target: Path, old: bytes, new: bytes) -> Path:
    """The same recording but for one change in its messages."""
    found = Contents(path)
    with target.open("wb") as file:
        writer = Writer(file)
        writer.start()
        for name, data in found.metadata.items():
            writer.add_metadata(name, data)
        numbers: dict[str, int] = {}
        for key, when, data in found.messages():
            if key not in numbers:
                numbers[key] = writer.register_channel(key, "json", 0)
            changed = data.replace(old, new) if b'"clearance"' in data else data
            writer.add_message(numbers[key], when, changed, when)
        writer.finish()
    return target


def test_the_trajectory_is_the_results(recording):
    assert verify(recording) == (recording.result["trajectory_sha256"], 0)


def test_one_changed_digit_is_an_error(path, recording, tmp_path):
    x = repr(recording.truths.positions[20, 0, 0].item()).encode()
    other = x[:-1] + (b"1" if x[-1:] != b"1" else b"2")
    altered = read(_altered(path, tmp_path / "altered.mcap", x, other))
    with pytest.raises(RecordingError, match=r"altered\.mcap: the recorded trajectory has hash"):
        verify(altered)


def _without_truths(recording: RecordedRun, lost: set[int]) -> RecordedRun:
    truths = recording.truths
    keep = ~np.isin(truths.ticks, list(lost))
    columns = (truths.ticks, truths.positions, truths.clearance, truths.phi, truths.log_potential)
    return replace(recording, truths=Truths(truths.robots, *(column[keep] for column in columns)))


def test_lost_truths_are_worked_out_from_measurements_to_the_last_bit(recording):
    last = int(recording.truths.ticks[-1])
    found = verify(_without_truths(recording, {5, 6, 20, last}))
    assert found == (recording.result["trajectory_sha256"], 3)
    assert found.remark == " (3 ticks worked out from odometry)"
    every = _without_truths(recording, set(range(1, last + 1)))
    assert verify(every) == (recording.result["trajectory_sha256"], last - 1)


def test_a_tick_that_nobody_knows_is_an_error_of_its_own(recording):
    known = recording.entries.where(lambda entry: not _is_measurement(entry.message, 2, 5))
    with pytest.raises(RecordingError, match="the truth of tick 5 was not recorded, nor what robot 2 did"):
        verify(_without_truths(replace(recording, entries=known), {5}))


def _is_measurement(message: Message, robot: int, tick: int) -> bool:
    return isinstance(message, Tick) and (message.robot, message.tick) == (robot, tick)


def test_without_a_result_there_is_nothing_to_compare(recording):
    assert verify(replace(recording, result=None)) is None


def test_everything_is_published_again_in_order(recording):
    entries = list(published(recording))
    assert [each.time for each in entries] == sorted(each.time for each in entries)
    assert len(entries) == recording.counts.total() + 1
    for said, entry in zip(entries, recording.entries, strict=False):
        assert (said.key, decode(said.key, said.payload)) == (entry.key, entry.message)
    assert isinstance(decode(entries[-1].key, entries[-1].payload), Result)


@pytest.mark.process
def test_a_recording_is_heard_over_zenoh(recording):
    router, endpoint = listening(Connection("router"))
    with closing(router), closing(ZenohBus(Connection(connect=(endpoint,)))) as listener:
        listener.subscribe(everything("again"))
        with closing(ZenohBus(Connection(connect=(endpoint,)))) as speaker:
            publish(recording, speaker, "again", speed=0.0)
            heard = _until_result(listener)
    expected = [Sample(each.key, each.payload) for each in published(recording, "again")]
    states = [sample for sample in expected if sample.key.endswith("/state")]
    assert [sample for sample in heard if sample.key.endswith("/state")] == states
    assert encode(Result("x"))[:10] == heard[-1].payload[:10]


def _until_result(bus: ZenohBus) -> list[Sample]:
    heard: list[Sample] = []
    deadline = time.monotonic() + 10.0
    while time.monotonic() < deadline and not (heard and heard[-1].key.endswith("/result")):
        event = bus.receive(0.1)
        if isinstance(event, Sample):
            heard.append(event)
    return heard


def test_commands_say_what_they_found(path, recording, tmp_path, capsys):
    replay(path)
    assert "as in the result" in capsys.readouterr().out
    info(path)
    said = capsys.readouterr().out
    for word in ("three, 3 robots", recording.result["verdict"], "complete", "disknav/three/robot/7/state"):
        assert word in said
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    info(cut)
    assert "cut short" in capsys.readouterr().out


@pytest.mark.process
def test_exit_status_of_the_command(path, recording, disknav, tmp_path):
    x = repr(recording.truths.positions[20, 0, 0].item()).encode()
    altered = _altered(path, tmp_path / "altered.mcap", x, x[:-1] + (b"1" if x[-1:] != b"1" else b"2"))
    for file, status in ((path, 0), (altered, 3), (tmp_path / "none.mcap", 2)):
        done = disknav("recording", "replay", file)
        assert done.returncode == status, done.stderr
