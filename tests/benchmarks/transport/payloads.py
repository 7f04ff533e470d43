"""What the floors send: as many bytes as the messages of a real fleet have on average."""

from collections import defaultdict
from functools import cache
from statistics import mean

from deploy.run.local import LocalFleet
from protocol.keys import everything, parse
from tests.benchmarks.crowds import restless
from tests.benchmarks.transport.bare import Payloads
from tests.listening import overhear


@cache
def payloads(robots: int) -> Payloads:
    """Of the first seconds of the fleet that is measured, in this process."""
    fleet, sizes = LocalFleet(restless(robots, seconds=5.0)), defaultdict[str, list[int]](list)

    def weigh(key: str, payload: bytes) -> None:
        sizes[parse(key).stream].append(len(payload))

    overhear(fleet.network, weigh, everything(fleet.run))
    fleet.execute()
    return Payloads(*(name[0].encode().ljust(round(mean(sizes[name])), b"\0") for name in Payloads._fields))
