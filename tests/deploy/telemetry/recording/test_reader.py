"""Recordings read back: whole, cut, damaged, and continued in further files."""

import json
import random
import struct
from contextlib import suppress
from io import BytesIO
from itertools import pairwise

import numpy as np
import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message
from mcap.stream_reader import StreamReader
from mcap.writer import Writer
from rosbags.highlevel import AnyReader

from deploy.run.local import LocalFleet
from deploy.telemetry.recording.reader import Contents, read
from deploy.telemetry.recording.replay import export, recomputed
from deploy.telemetry.scene import TOPICS
from protocol.errors import RecordingError, UsageError
from protocol.keys import parse
from protocol.messages import Clock, Command, Health, State, Tick
from tests.deploy.telemetry.recording.recorded import ROBOTS, rewritten, said_by, scenario


def edges(data: bytes) -> list[tuple[int, bool]]:
    stream = BytesIO(data)
    records = StreamReader(stream, emit_chunks=True).records
    return [(stream.tell(), isinstance(record, Chunk)) for record in records]


@pytest.mark.slow
def test_a_file_cut_anywhere_is_read_to_the_cut(recorded, tmp_path):
    """By this software and by stock tools; what is cut before the run began holds nothing, and says so."""
    whole = recorded[0].read_bytes()
    entries = list(read(recorded[0]).entries)
    ends = [end for end, _ in edges(whole)][::9]
    spread = range(0, len(whole), len(whole) // 12)
    places = sorted({0, 8, *ends, *(end + 5 for end in ends), *spread, len(whole) - 1} - {len(whole)})
    known = {repr(entry) for entry in entries}
    path, seen, best = tmp_path / "cut.mcap", 0, 0
    for place in places:
        path.write_bytes(whole[:place])
        try:
            found = read(path)
        except RecordingError as error:
            assert seen == 0, f"unreadable when cut at {place}, readable when cut before"
            assert "nothing was recorded" in str(error) or 0 < place < 8
            continue
        seen += 1
        assert found.cut
        kept = list(found.entries)
        assert len(kept) == found.counts.total() == stock(path) >= best
        best = len(kept)
        assert {repr(entry) for entry in kept} <= known
    assert seen > len(places) // 2
    assert best == len(entries)


def stock(path) -> int:
    """How many messages of the run the library finds in a cut file."""
    topics, found = {}, 0
    with path.open("rb") as file, suppress(McapError, struct.error):  # there is no end
        for record in StreamReader(file).records:
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Message):
                found += not topics[record.channel_id].startswith("/")
    return found


def test_a_damaged_file_is_read_to_the_damage(recorded, tmp_path):
    data = bytearray(recorded[0].read_bytes())
    (start, _), (end, _) = [pair for pair in pairwise(edges(data)) if pair[1][1]][-1]
    data[(start + end) // 2] ^= 0xFF
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    found = read(path)
    assert found.cut
    assert found.counts.total() == len(list(found.entries)) < len(list(read(recorded[0]).entries))


@pytest.mark.parametrize(
    ("content", "error", "said"),
    [
        (b"PNG", UsageError, "is not a recording"),
        (b"", RecordingError, "is empty: nothing was recorded"),
        (b"\x89MCAP0\r\n", RecordingError, "was cut before the run began; nothing was recorded"),
        (b"\x89MCAP0\r\n\1" + (2**60).to_bytes(8, "little"), RecordingError, "was cut before the run began"),
    ],
    ids=["foreign", "empty", "header only", "endless record"],
)
def test_what_holds_no_recording_says_so(tmp_path, content, error, said):
    path = tmp_path / "nothing.mcap"
    with pytest.raises(UsageError, match=r"nothing\.mcap: No such file"):
        read(path)
    path.write_bytes(content)
    with pytest.raises(error, match=said):
        read(path)


def test_a_whole_file_of_others_says_so(tmp_path):
    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()
    with pytest.raises(UsageError, match="holds no scenario: disknav did not write it"):
        read(path)


@pytest.mark.parametrize(
    "report",
    [
        *("3", "[]", '"arrived"', '{"ticks": 4}', '{"verdict": "arrived", "ticks": -1}', "[" * 100_000),
        '{"verdict": "arrived", "ticks": 4, "positions": 3}',
        '{"verdict": "arrived", "ticks": 4, "worlds": "x"}',
    ],
    ids=range(8),
)
def test_a_result_of_another_form_is_refused(recorded, tmp_path, report):
    with pytest.raises(RecordingError, match=r"other\.mcap was written by another version"):
        read(rewritten(recorded[0], tmp_path / "other.mcap", result={"json": report}))


def test_a_result_of_a_far_later_tick_is_not_compared(recorded, tmp_path):
    result = {"json": json.dumps(recorded[1] | {"ticks": 10**15})}
    with pytest.raises(RecordingError, match="most of its ticks were not"):
        recomputed(read(rewritten(recorded[0], tmp_path / "far.mcap", result=result)))


@pytest.mark.parametrize(
    ("metadata", "cut"),
    [({"run": {}}, False)]
    + [({"recorder": {"following": name}}, True) for name in ("/", "..", "a\0b", "x" * 5000, "other.mcap")],
)
def test_without_its_run_or_with_a_following_file_that_is_missing_nothing_is_lost(
    recorded, tmp_path, metadata, cut
):
    found, whole = read(rewritten(recorded[0], tmp_path / "first.mcap", **metadata)), read(recorded[0])
    assert found.cut is cut
    assert found.counts == whole.counts
    assert found.trajectory.ticks.tolist() == whole.trajectory.ticks.tolist()


def test_what_is_not_read_is_told(recorded, tmp_path):
    """Behind the end of the file, or outside of chunks."""
    path, whole = tmp_path / "two.mcap", recorded[0].read_bytes()
    path.write_bytes(whole + whole)
    assert read(path).cut
    assert recomputed(read(path)) == recomputed(read(recorded[0]))
    with pytest.raises(UsageError, match="outside of chunks"):
        read(rewritten(recorded[0], path, chunks=False))


def test_messages_come_in_the_order_of_time_however_late_they_were_written(tmp_path):
    path, draw = tmp_path / "late.mcap", random.Random(7)
    times = [max(0, tick - draw.choice((0, 0, 0, 40, 900))) for tick in range(1000)]
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        number = writer.register_channel("topic", "json", 0)
        for index, time in enumerate(times):
            writer.add_message(number, time, b"%d" % index, time)
            if index % 70 == 0:
                writer.flush()
        writer.finish()
    found = Contents(path)
    assert [(time, int(data)) for _, time, data in found.messages()] == sorted(
        zip(times, range(1000), strict=True)
    )
    assert not found.cut


def test_a_recording_holds_a_scene_that_follows_the_truth(recorded):
    path, _ = recorded
    found = read(path)
    with path.open("rb") as file:
        drawn = [
            (channel.topic, message) for _, channel, message in make_reader(file).iter_messages([*TOPICS])
        ]
    assert {topic for topic, _ in drawn} == set(TOPICS)
    frames = [message for topic, message in drawn if topic == "/tf"]
    ticks = found.trajectory.ticks.tolist()
    assert len(frames) >= len(ticks) // 2
    for frame in frames:
        row = ticks.index(round(frame.log_time / 1e9 / 0.05))
        moved = json.loads(frame.data)["transforms"]
        told = [(each["translation"]["x"], each["translation"]["y"]) for each in moved]
        assert np.allclose(told, found.trajectory.positions[row], rtol=0.0, atol=1e-5)
        assert [each["child_frame_id"] for each in moved] == ["robot_1", "robot_2", "robot_7"]


def test_ros_tools_open_what_is_exported(recorded, tmp_path):
    path, report = recorded
    export(read(path), tmp_path / "ros.mcap")
    with AnyReader([tmp_path / "ros.mcap"]) as bag:
        (connection,) = bag.connections
        assert (connection.topic, connection.msgtype) == ("/tf", "tf2_msgs/msg/TFMessage")
        times = [time for _, time, _ in bag.messages()]
        *_, (_, _, last) = bag.messages()
        final = bag.deserialize(last, connection.msgtype).transforms[1].transform.translation
    assert times == [tick * 50_000_000 for tick in range(report["ticks"] + 1)]
    assert [final.x, final.y] == read(path).trajectory.positions[-1][1].tolist()


def test_any_mcap_reader_reads_it(recorded):
    path, report = recorded
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        own = [channel for channel in summary.channels.values() if channel.topic not in TOPICS]
        topics = [channel.topic for channel in own]
        assert len(topics) == len(set(topics)) == 2 + 4 * len(ROBOTS)
        assert {summary.schemas[each.schema_id].encoding for each in own} == {"jsonschema"}
        assert {channel.message_encoding for channel in own} == {"json"}
        for _, channel, message in reader.iter_messages(topics):
            content = json.loads(message.data)
            assert message.log_time == round(content["tick"] * 0.05 * 1e9)
            assert content.get("robot") == parse(channel.topic).robot
        metadata = {each.name: each.metadata for each in reader.iter_metadata()}
    assert json.loads(metadata["scenario"]["json"])["name"] == "three"
    assert json.loads(metadata["result"]["json"])["trajectory_sha256"] == report["trajectory_sha256"]
    assert metadata["run"]["name"] == "three"


def test_what_is_read_is_what_was_run_and_would_have_been_without_a_recording(recorded):
    path, report = recorded
    found, bare = read(path), LocalFleet(scenario(), "three").execute()
    assert bare["trajectory_sha256"] == report["trajectory_sha256"]
    assert found.scenario == scenario()
    assert found.result == report
    assert not found.cut
    assert recomputed(found).sha256 == report["trajectory_sha256"]
    assert found.trajectory.ticks.tolist() == list(range(report["ticks"] + 1))
    assert found.trajectory.missing == 0
    assert found.trajectory.clearance.min() == report["min_clearance"]
    assert np.array_equal(found.trajectory.positions[0], [spec.start for spec in ROBOTS])
    for spec in ROBOTS:
        told = [tick.tick for tick in said_by(found, Tick, spec.id) if not tick.over]
        assert told == list(range(report["ticks"]))
        assert [command.tick for command in said_by(found, Command, spec.id)] == told
        assert [state.tick for state in said_by(found, State, spec.id)] == list(range(report["ticks"]))
        assert said_by(found, Health, spec.id)
    assert list(found.messages(Clock))[-1].verdict == report["verdict"]


def test_the_launchers_result_takes_the_place_of_the_worlds(tmp_path):
    path = tmp_path / "complete.mcap"
    with LocalFleet(scenario(), "three", record=path) as fleet:
        report = fleet.execute()
        fleet.record(report | {"transport": "local"})
    found = read(path)
    assert found.result == report | {"transport": "local"}
    assert not found.cut
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        said = sum(channel.topic not in TOPICS for _, channel, _ in reader.iter_messages())
        assert said == found.counts.total() == len(list(found.entries))
        assert len(list(reader.iter_metadata())) == reader.get_summary().statistics.metadata_count == 4
