"""Small runs, recorded for tests of recordings and pictures; and a world that says whatever a test wants."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from mcap.writer import Writer

from deploy.run.local import LocalFleet
from deploy.telemetry.recording.reader import Recording
from protocol import joining
from protocol.bus.bus import Query
from protocol.keys import STREAMS, parse, world_key, world_token
from protocol.scenario.model import Control, RobotSpec, Scenario, Time

ROBOTS = (
    RobotSpec(1, 0.03, (-0.1, 0.01), (0.1, 0.0)),
    RobotSpec(2, 0.03, (0.1, -0.01), (-0.1, 0.0)),
    RobotSpec(7, 0.03, (0.0, 0.2), (0.0, 0.1)),
)


def scenario(**changes: Any) -> Scenario:
    return Scenario(
        **({"robots": ROBOTS, "name": "three", "control": Control(k=4.0), "time": Time(limit=5.0)} | changes)
    )


def record(path: Path, **changes: Any) -> dict[str, Any]:
    """Record a run in this process; returns the world's report."""
    with LocalFleet(scenario(**changes), "three", record=path) as fleet:
        return fleet.execute()


def said_by(recording: Recording, kind: type[Any], robot: int) -> list[Any]:
    return [message for message in recording.messages(kind) if message.robot == robot]


def rewritten(
    path: Path,
    target: Path,
    change: Callable[[bytes], bytes] = lambda data: data,
    *,
    chunks: bool = True,
    **metadata: dict[str, str],
) -> Path:
    """A copy of a recording whose messages were changed, and whose metadata are others; none where empty."""
    with path.open("rb") as source, target.open("wb") as copy:
        reader, writer, numbers = make_reader(source), Writer(copy, use_chunking=chunks), {}
        writer.start()
        kept = {each.name: each.metadata for each in reader.iter_metadata()} | metadata
        for name, about in kept.items():
            if about:
                writer.add_metadata(name, about)
        for _, channel, message in reader.iter_messages(log_time_order=False):
            if channel.topic not in numbers:
                numbers[channel.topic] = writer.register_channel(channel.topic, "json", 0)
            number, time = numbers[channel.topic], message.log_time
            writer.add_message(number, time, change(message.data), message.publish_time)
        writer.finish()
    return target


class FakeWorld:
    """Answers requests for the scenario, and publishes the messages of a test."""

    finished, deadline = False, float("inf")

    def __init__(self, bus, run: str) -> None:
        self.replies: list[bytes] = []  # to the first request
        self._bus, self._run = bus, run
        bus.node = self
        bus.serve(world_key(run, "scenario"))
        bus.announce(world_token(run, "1"))

    def handle(self, event) -> None:
        if isinstance(event, Query):
            overview = joining.encode_reply(joining.Overview(scenario(), True))
            event.reply(self.replies.pop(0) if self.replies else overview)

    def say(self, key: str, payload: bytes) -> None:
        self._bus.publisher(STREAMS[parse(key).stream], key)(payload)
