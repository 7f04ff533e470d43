"""What the floors send: as many bytes as the messages of a real fleet have on average."""

from collections import Counter
from functools import cache
from math import inf

from deploy.run.local import LocalFleet
from protocol.bus.bus import Event, Sample
from protocol.keys import everything, parse
from tests.benchmarks.crowds import restless
from tests.benchmarks.transport.bare import Payloads


class Scale:
    """Weighs everything that is said."""

    finished = False
    deadline = inf

    def __init__(self) -> None:
        self.bytes: Counter[str] = Counter()
        self.messages: Counter[str] = Counter()

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            stream = parse(event.key).stream
            self.bytes[stream] += len(event.payload)
            self.messages[stream] += 1

    def wake(self, now: float) -> None:
        """Nothing is due by the wall clock."""

    def mean(self, stream: str) -> bytes:
        return stream[0].encode().ljust(round(self.bytes[stream] / self.messages[stream]), b"\0")


@cache
def payloads(robots: int) -> Payloads:
    """Of the first seconds of the fleet that is measured, in this process."""
    fleet, scale = LocalFleet(restless(robots, seconds=5.0)), Scale()
    bus = fleet.network.connect()
    bus.subscribe(everything(fleet.run))
    bus.node = scale
    fleet.execute()
    return Payloads(*map(scale.mean, Payloads._fields))
