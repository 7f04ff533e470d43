"""A world that says whatever a test wants."""

from protocol import joining
from protocol.bus.bus import Query
from protocol.keys import parse, world_key, world_token
from protocol.streams import STREAMS
from tests.deploy.telemetry.recording.recorded import scenario


class FakeWorld:
    """Answers requests for the scenario, and publishes the messages of a test."""

    finished, deadline = False, float("inf")

    def __init__(self, bus, run: str) -> None:
        self.tick = 0
        self.replies: list[bytes] = []  # to the first request
        self._bus, self._run = bus, run
        self._publish = {}
        if hasattr(bus, "node"):
            bus.node = self
        bus.serve(world_key(run, "scenario"))
        bus.announce(world_token(run, "1"))

    def handle(self, event) -> None:
        if isinstance(event, Query):
            overview = joining.encode_reply(joining.Overview(scenario(), True))
            event.reply(self.replies.pop(0) if self.replies else overview)

    def say(self, key: str, payload: bytes) -> None:
        if key not in self._publish:
            self._publish[key] = self._bus.publisher(STREAMS[parse(key).stream], key)
        self._publish[key](payload)
