"""Recordings: what is written, that any MCAP reader reads it, and what is left of a file that was cut."""

import json
import multiprocessing
import os
import signal
import struct
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader

from deploy.recording import process
from deploy.recording.beside import FileBeside
from deploy.recording.contents import records
from deploy.recording.form import from_object, schema, to_object
from deploy.recording.reader import read, trajectory_hash
from deploy.recording.recorder import Recorder
from deploy.recording.result import attach
from deploy.recording.writer import RecordingFile
from deploy.router import listening
from protocol import joining
from protocol.bus import Request, Sample
from protocol.bus_local import LocalNetwork
from protocol.bus_zenoh import ZenohBus
from protocol.codec import encode
from protocol.connection import Connection
from protocol.errors import BusError, RecordingError, UsageError
from protocol.keys import everything, parse, robot_key, world_key
from protocol.messages import (
    Answer,
    Clock,
    Command,
    Down,
    Health,
    Measurement,
    Proposal,
    Result,
    State,
    Truth,
)
from protocol.streams import STREAMS
from tests.deploy.recorded import ROBOTS, record, scenario

RECORDED = [stream for stream in STREAMS.values() if stream.recorded]
number = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(min_value=0, allow_nan=False, allow_infinity=False)
vector = st.tuples(number, number)
count = st.integers(0, 2**53)
robot = st.integers(1, 999_999_999)
downs = st.lists(st.builds(Down, robot, count, vector), max_size=2).map(tuple)
ids = st.lists(robot, max_size=3).map(tuple)


def several(strategy):
    return st.lists(strategy, max_size=3).map(tuple)


messages = st.one_of(
    st.builds(Measurement, robot, count, count, st.none() | vector, count, vector, ids, downs, st.booleans()),
    st.builds(
        State, robot, count, count, st.none() | vector, positive, positive, positive, vector,
        several(st.builds(Proposal, robot, count, count, number, number, number)),
        several(st.builds(Answer, robot, count, count, count)),
    ),
    st.builds(Command, robot, count, count, vector),
    st.builds(Clock, count, positive, ids, downs, st.text(max_size=9), count, number, number),
    st.builds(Truth, count, ids, several(vector), number, number),
    st.builds(
        Health, robot, count, count, positive, count, count,
        st.dictionaries(st.text(max_size=5), count, max_size=2),
        several(st.tuples(robot, count)), several(st.tuples(robot, number, number, number)),
        st.text(max_size=9),
    ),
)  # fmt: skip


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> tuple[Path, dict]:
    """A recording and the report of its run."""
    path = tmp_path_factory.mktemp("recording") / "three.mcap"
    return path, record(path)


class Spy:
    """Hears everything of a run."""

    finished, deadline = False, float("inf")

    def __init__(self, bus, run: str) -> None:
        self.heard: list[Sample] = []
        bus.subscribe(everything(run))
        bus.node = self

    def handle(self, event) -> None:
        self.heard.append(event)


class FakeWorld:
    """Answers who asks for the scenario, and says whatever the test wants."""

    finished, deadline = False, float("inf")

    def __init__(self, bus, run: str) -> None:
        self.tick = 0
        self._bus, self._run = bus, run
        self._publish = {}
        if hasattr(bus, "node"):
            bus.node = self
        bus.serve(world_key(run, "scenario"))
        bus.announce(world_key(run, "alive"))

    def handle(self, event) -> None:
        if isinstance(event, Request):
            event.reply(joining.encode_reply(joining.Overview(scenario(), True)))

    def say(self, key: str, payload: bytes) -> None:
        if key not in self._publish:
            self._publish[key] = self._bus.publisher(STREAMS[parse(key).stream], key)
        self._publish[key](payload)


# -- the form of messages


@given(messages)
def test_messages_survive_json_to_the_last_bit(message):
    text = msgspec.json.encode(to_object(type(message))(message))
    assert encode(from_object(type(message), msgspec.json.decode(text))) == encode(message)


@given(messages)
def test_objects_keep_to_their_schema(message):
    content = msgspec.json.decode(msgspec.json.encode(to_object(type(message))(message)))
    _conforms(content, schema(type(message)))


def _conforms(value, described: dict) -> None:
    kinds = {"boolean": bool, "integer": int, "number": float, "string": str, "object": dict, "array": list}
    assert type(value) is kinds[described["type"]]
    if described["type"] == "array":
        for item in value:
            _conforms(item, described["items"])
    elif described["type"] == "object":
        assert set(described.get("required", ())) <= set(value)
        for name, inner in value.items():
            _conforms(inner, described["properties"].get(name) or described["additionalProperties"])


@pytest.mark.parametrize("stream", RECORDED, ids=lambda stream: stream.name)
def test_schemas_keep_to_what_foxglove_reads(stream):
    """Its parser wants properties in every object, one plain type each, and no arrays of arrays."""

    def check(described: dict) -> None:
        assert described["type"] in ("boolean", "integer", "number", "string", "object", "array")
        if described["type"] == "object":
            for inner in described["properties"].values():
                check(inner)
        if described["type"] == "array":
            assert described["items"]["type"] != "array"
            check(described["items"])

    check(schema(stream.message))


# -- a whole recording


def test_any_mcap_reader_reads_it(recorded):
    path, report = recorded
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        topics = [channel.topic for channel in summary.channels.values()]
        assert len(topics) == len(set(topics)) == 2 + 4 * len(ROBOTS)
        assert {each.encoding for each in summary.schemas.values()} == {"jsonschema"}
        assert {channel.message_encoding for channel in summary.channels.values()} == {"json"}
        for _, channel, message in reader.iter_messages():
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
    assert trajectory_hash(found) == report["trajectory_sha256"]
    assert found.truths.ticks.tolist() == list(range(report["ticks"] + 1))
    assert found.truths.missing == 0
    assert found.truths.clearance.min() == report["min_clearance"]
    assert np.array_equal(found.truths.positions[0], [spec.start for spec in ROBOTS])
    for spec in ROBOTS:
        told = [measurement.tick for measurement in found.measurements[spec.id] if not measurement.over]
        assert told == [command.tick for command in found.commands[spec.id]] == list(range(report["ticks"]))
        assert [state.tick for state in found.states[spec.id]] == list(range(report["ticks"]))
        assert found.health[spec.id]
    assert found.clocks[-1].verdict == report["verdict"]


def test_everything_that_was_said_is_recorded_in_order(tmp_path):
    from deploy.local import LocalFleet

    fleet = LocalFleet([scenario()], "three", record=tmp_path / "spied.mcap")
    spy = Spy(fleet.network.connect(), "three")
    fleet.execute()
    found = read(tmp_path / "spied.mcap")
    said: dict[str, list[bytes]] = {}
    for sample in spy.heard:
        if STREAMS[parse(sample.key).stream].recorded:
            said.setdefault(sample.key, []).append(sample.payload)
    for key, payloads in said.items():
        kept = [encode(entry.message) for entry in found.entries if entry.key == key]
        assert kept[: len(payloads)] == payloads
    assert found.counts().keys() == said.keys()
    assert [entry.time for entry in found.entries] == sorted(entry.time for entry in found.entries)


def test_recording_does_not_change_the_run(recorded):
    from deploy.local import LocalFleet

    (report,) = LocalFleet([scenario()], "three").execute()
    assert report["trajectory_sha256"] == recorded[1]["trajectory_sha256"]


def test_the_launchers_result_is_added(recorded, tmp_path):
    path = tmp_path / "attached.mcap"
    path.write_bytes(recorded[0].read_bytes())
    for transport in ("mesh", "routed"):
        attach(path, recorded[1] | {"transport": transport})
    found = read(path)
    assert found.result["transport"] == "routed"
    assert not found.cut
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert sum(1 for _ in reader.iter_messages()) == len(found.entries)
        assert len(list(reader.iter_metadata())) == reader.get_summary().statistics.metadata_count == 6


# -- damage


def test_a_file_cut_anywhere_is_read_to_the_cut(recorded, tmp_path):
    whole = recorded[0].read_bytes()
    entries = read(recorded[0]).entries
    edges = [place for _, start, end in records(whole) for place in (start, start + 5, end - 1)]
    places = sorted({*edges[::3], *range(0, len(whole), max(1, len(whole) // 40)), len(whole) - 1})
    known = {repr(entry) for entry in entries}
    path, seen, best = tmp_path / "cut.mcap", 0, 0
    for place in places:
        path.write_bytes(whole[:place])
        try:
            found = read(path)
        except RecordingError:
            assert seen == 0, f"unreadable when cut at {place}, readable when cut before"
            continue
        seen += 1
        assert found.cut
        assert len(found.entries) >= best
        best = len(found.entries)
        assert {repr(entry) for entry in found.entries} <= known
    assert seen > len(places) // 2
    assert best == len(entries)


def test_a_damaged_file_is_read_to_the_damage(recorded, tmp_path):
    data = bytearray(recorded[0].read_bytes())
    chunks = [(start, end) for opcode, start, end in records(bytes(data)) if opcode == 6]
    start, end = chunks[-1]
    data[(start + end) // 2] ^= 0xFF
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    assert read(path).cut


def test_a_file_that_was_cut_gets_an_end_with_its_result(recorded, tmp_path):
    whole = recorded[0].read_bytes()
    ends = [end for opcode, _, end in records(whole) if opcode == 7]
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: ends[-1] + 3])
    attach(path, {"verdict": "aborted"})
    found = read(path)
    assert found.result == {"verdict": "aborted"}
    assert found.cut
    assert len(found.entries) == len(read(recorded[0]).entries)


def test_what_is_no_recording_says_so(tmp_path):
    nothing = tmp_path / "nothing.mcap"
    with pytest.raises(UsageError, match=r"nothing\.mcap: No such file"):
        read(nothing)
    nothing.write_bytes(b"PNG")
    with pytest.raises(RecordingError, match="is not a recording"):
        read(nothing)
    with pytest.raises(RecordingError, match="is not a recording"):
        attach(nothing, {})


# -- the recorder


def test_what_is_no_message_of_the_run_is_counted_not_recorded(tmp_path):
    network = LocalNetwork()
    world = FakeWorld(network.connect(), "fake")
    bus = network.connect()
    recorder = bus.node = Recorder(bus, "fake", tmp_path / "fake.mcap")
    command = Command(1, 1, 0, (0.1, 0.2))
    good, foreign = robot_key("fake", 1, "command"), robot_key("fake", 5, "command")
    for key, payload in (
        (good, encode(command)),
        (good, b"\x93"),
        (good, encode(msgspec.structs.replace(command, velocity=(float("nan"), 0.0)))),
        (good, encode(msgspec.structs.replace(command, robot=2))),
        (foreign, encode(msgspec.structs.replace(command, robot=5))),
        (good, bytes(2000)),
    ):
        world.say(key, payload)
    world.say(world_key("fake", "result"), encode(Result('{"verdict": "arrived"}')))
    network.run(lambda: recorder.finished)
    found = read(tmp_path / "fake.mcap")
    assert [entry.message for entry in found.entries] == [command]
    assert found.result == {"verdict": "arrived"}
    with (tmp_path / "fake.mcap").open("rb") as file:
        metadata = {each.name: each.metadata for each in make_reader(file).iter_metadata()}
    assert json.loads(metadata["recorder"]["rejected"]) == {
        "shape": 1,
        "not-finite": 1,
        "identity": 1,
        "key": 1,
        "oversize": 1,
    }


def test_a_file_that_cannot_be_created_is_refused_at_once(tmp_path):
    with pytest.raises(UsageError, match=r"cannot record to .*x\.mcap"):
        Recorder(LocalNetwork().connect(), "r", tmp_path / "no" / "x.mcap")


def test_the_same_when_another_process_writes(tmp_path):
    with pytest.raises(UsageError, match=r"cannot record to .*x\.mcap"):
        FileBeside(tmp_path / "no" / "x.mcap")
    here, beside = RecordingFile(tmp_path / "here.mcap"), FileBeside(tmp_path / "beside.mcap")
    for file in (here, beside):
        file.begin("r", scenario())
        file.write([Sample(robot_key("r", 1, "command"), encode(Command(1, 1, 0, (0.1, 0.2))))])
        file.flush()
        file.finish('{"verdict": "arrived"}')
    assert (tmp_path / "here.mcap").read_bytes() == (tmp_path / "beside.mcap").read_bytes()


def test_the_end_of_the_process_that_writes_is_an_error(tmp_path):
    file = FileBeside(tmp_path / "x.mcap")
    (child,) = multiprocessing.active_children()
    child.kill()
    child.join(10)
    with pytest.raises(RecordingError, match=r"cannot go on recording to .*x\.mcap"):
        file.begin("r", scenario())


def test_a_world_that_never_appears_ends_the_wait(tmp_path):
    bus = LocalNetwork().connect()
    recorder = Recorder(bus, "r", tmp_path / "x.mcap", patience=0.01)
    assert recorder.deadline < time.monotonic() + 0.02
    with pytest.raises(BusError, match="no world to record within"):
        recorder.wake(recorder.deadline)


def test_the_end_of_the_world_ends_the_recording(tmp_path):
    network = LocalNetwork()
    bus = network.connect()
    world = FakeWorld(bus, "gone")
    listener = network.connect()
    recorder = listener.node = Recorder(listener, "gone", tmp_path / "gone.mcap")
    recorder.handle(listener.receive(0.0))
    world.say(robot_key("gone", 1, "command"), encode(Command(1, 1, 0, (0.1, 0.2))))
    bus.close()
    network.run(lambda: recorder.finished)
    found = read(tmp_path / "gone.mcap")
    assert (len(found.entries), found.result, found.cut) == (1, None, False)


# -- the process


def _feed(world: FakeWorld, bus, until: Callable[[], bool]) -> int:
    """Publish truths, up to a thousand a second, until told; returns the last tick."""
    positions = tuple(spec.start for spec in ROBOTS)
    robots = tuple(spec.id for spec in ROBOTS)
    deadline = time.monotonic() + 20.0
    while not until():
        assert time.monotonic() < deadline, "the recorder does not record"
        world.tick += 1
        event = bus.receive(0.001)
        if event is not None:
            world.handle(event)
        world.say(world_key("lost", "truth"), encode(Truth(world.tick, robots, positions, 0.1, 0.5)))
    return world.tick


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
        safe = world.tick
        _feed(world, bus, _after(1.0))
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


def test_nothing_reads_past_the_end():
    assert list(records(b"\x89MCAP0\r\n" + struct.pack("<BQ", 5, 2**60))) == []
