"""A message that a network loses costs a lock-step run a moment, no robot, and no bit of the trajectory."""

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Event, Sample
from protocol.codec import decode
from protocol.messages import Command, State, Tick
from tests.proxy import Proxy
from tests.skipped_waits import skipped_waits

SCENARIO = load("swap-4")
LOST_AT = (0, 7)  # ticks


@pytest.mark.parametrize(("listener", "kind"), [(2, State), (2, Tick), (None, Command)])
@pytest.mark.slow
@skipped_waits()
def test_what_is_lost_is_said_again(listener: int | None, kind: type[Tick | State | Command]) -> None:
    """A node does not hear the first message of a kind, from any sender, at some ticks."""
    whole = LocalFleet(SCENARIO).execute()
    fleet, left = LocalFleet(SCENARIO), [*LOST_AT]
    bus = fleet.world_bus if listener is None else fleet.robots[listener]
    node = bus.node

    def handle(event: Event) -> None:
        message = decode(event.key, event.payload) if isinstance(event, Sample) else None
        if isinstance(message, kind) and message.tick in left[:1]:
            left.pop(0)
        else:
            node.handle(event)

    bus.node = Proxy(node, handle=handle)
    report = fleet.execute()
    assert (left, report["verdict"]) == ([], "arrived")
    assert report["trajectory_sha256"] == whole["trajectory_sha256"]
    assert report["ticks"] == whole["ticks"]
