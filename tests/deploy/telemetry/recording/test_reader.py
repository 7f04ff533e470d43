"""Recordings: what is written is what was said, and any MCAP reader reads it."""

import json
import tracemalloc

import numpy as np
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from deploy.run.local import LocalFleet
from deploy.telemetry.recording.reader import Contents, read
from deploy.telemetry.recording.replay import export, trajectory
from deploy.telemetry.recording.writer import RecordingFile
from deploy.telemetry.scene.fleet import TOPICS
from deploy.telemetry.scene.ros import NAME
from protocol.bus.bus import Sample
from protocol.codec import decode, encode
from protocol.keys import everything, parse, robot_key
from protocol.messages import Clock, Command, Health, State, Tick
from protocol.streams import STREAMS
from tests.deploy.telemetry.recording.recorded import ROBOTS, said_by, scenario


class Spy:
    """Hears everything of a run."""

    finished, deadline = False, float("inf")

    def __init__(self, bus, run: str) -> None:
        self.heard: list[Sample] = []
        bus.subscribe(everything(run))
        bus.node = self

    def handle(self, event) -> None:
        self.heard.append(event)


def own(summary):
    """The channels of the run, without those that draw it."""
    return [channel for channel in summary.channels.values() if channel.topic not in TOPICS]


def test_a_recording_holds_a_scene_that_follows_the_truth(recorded):
    path, _ = recorded
    store, found = get_typestore(Stores.ROS2_HUMBLE), read(path)
    with path.open("rb") as file:
        drawn = [
            (channel.topic, message) for _, channel, message in make_reader(file).iter_messages([*TOPICS])
        ]
    assert {topic for topic, _ in drawn} == set(TOPICS)
    frames = [message for topic, message in drawn if topic == "/tf"]
    ticks = found.truths.ticks.tolist()
    assert len(frames) >= len(ticks) // 2
    for frame in frames:
        row = ticks.index(round(frame.log_time / 1e9 / 0.05))
        moved = store.deserialize_cdr(frame.data, NAME).transforms
        told = [(each.transform.translation.x, each.transform.translation.y) for each in moved]
        assert told == [tuple(place) for place in found.truths.positions[row].tolist()]
        assert [each.child_frame_id for each in moved] == ["robot_1", "robot_2", "robot_7"]


def test_ros_tools_open_what_is_exported(recorded, tmp_path):
    path, report = recorded
    export(read(path), tmp_path / "ros.mcap")
    with AnyReader([tmp_path / "ros.mcap"]) as bag:
        (connection,) = bag.connections
        assert (connection.topic, connection.msgtype) == ("/tf", NAME)
        times = [time for _, time, _ in bag.messages()]
        *_, (_, _, last) = bag.messages()
        final = bag.deserialize(last, NAME).transforms[1].transform.translation
    assert times == [tick * 50_000_000 for tick in range(report["ticks"] + 1)]
    assert [final.x, final.y] == read(path).truths.positions[-1][1].tolist()


def test_any_mcap_reader_reads_it(recorded):
    path, report = recorded
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        topics = [channel.topic for channel in summary.channels.values() if channel.topic not in TOPICS]
        assert len(topics) == len(set(topics)) == 2 + 4 * len(ROBOTS)
        assert {summary.schemas[each.schema_id].encoding for each in own(summary)} == {"jsonschema"}
        assert {channel.message_encoding for channel in own(summary)} == {"json"}
        for _, channel, message in reader.iter_messages(topics):
            content = json.loads(message.data)
            assert message.log_time == round(content["tick"] * 0.05 * 1e9)
            assert content.get("robot") == parse(channel.topic).robot
        metadata = {each.name: each.metadata for each in reader.iter_metadata()}
    assert json.loads(metadata["scenario"]["json"])["name"] == "three"
    assert json.loads(metadata["result"]["json"])["trajectory_sha256"] == report["trajectory_sha256"]
    assert metadata["run"]["name"] == "three"


def test_what_is_read_is_what_was_run(recorded):
    path, report = recorded
    found = read(path)
    assert found.scenario == scenario()
    assert found.result == report
    assert not found.cut
    assert trajectory(found).sha256 == report["trajectory_sha256"]
    assert found.truths.ticks.tolist() == list(range(report["ticks"] + 1))
    assert found.truths.missing == 0
    assert found.truths.clearance.min() == report["min_clearance"]
    assert np.array_equal(found.truths.positions[0], [spec.start for spec in ROBOTS])
    for spec in ROBOTS:
        told = [tick.tick for tick in said_by(found, Tick, spec.id) if not tick.over]
        assert told == list(range(report["ticks"]))
        assert [command.tick for command in said_by(found, Command, spec.id)] == told
        assert [state.tick for state in said_by(found, State, spec.id)] == list(range(report["ticks"]))
        assert said_by(found, Health, spec.id)
    assert list(found.said(Clock))[-1].verdict == report["verdict"]


def test_everything_that_was_said_is_recorded_in_order(tmp_path):
    with LocalFleet(scenario(), "three", record=tmp_path / "spied.mcap") as fleet:
        spy = Spy(fleet.network.connect(), "three")
        fleet.execute()
    found = read(tmp_path / "spied.mcap")
    said: dict[str, list[bytes]] = {}
    for sample in spy.heard:
        if STREAMS[parse(sample.key).stream].recorded:
            message = decode(sample.key, sample.payload)  # a bound of 0 is sent as an integer
            said.setdefault(sample.key, []).append(encode(message))
    for key, payloads in said.items():
        kept = [encode(entry.message) for entry in found.entries if entry.key == key]
        assert kept[: len(payloads)] == payloads
    assert found.counts.keys() == said.keys()
    assert [entry.time for entry in found.entries] == sorted(entry.time for entry in found.entries)


def test_recording_does_not_change_the_run(recorded):
    report = LocalFleet(scenario(), "three").execute()
    assert report["trajectory_sha256"] == recorded[1]["trajectory_sha256"]


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


def test_reading_takes_no_more_memory_for_a_longer_recording(tmp_path):
    peaks = []
    keys = {spec.id: robot_key("r", spec.id, "command") for spec in ROBOTS}
    for ticks in (1000, 5000):
        path = tmp_path / f"{ticks}.mcap"
        file = RecordingFile(path, "r", scenario())
        for tick in range(ticks):
            file.write([(key, encode(Command(robot, 1, tick, (0.1, 0.2)))) for robot, key in keys.items()])
        file.finish()
        found = Contents(path)
        tracemalloc.start()
        assert sum(1 for _ in found.messages()) == 3 * ticks
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 2.0 * peaks[0]
