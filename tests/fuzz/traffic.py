"""What real runs with faults say, for damage to begin from."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from functools import cache
from unittest.mock import patch

from deploy.library.figures import crash
from deploy.run.local import LocalFleet
from protocol.bus.bus import Event, Sample
from protocol.codec import encode
from protocol.keys import everything, robot_key
from protocol.scenario.model import Network
from protocol.streams import STREAMS
from tests.campaigns.faults import fault_scenario
from tests.protocol.sample_messages import ONE

EPOCH = 7  # of all coordinators, so that what one run says counts in another
_KEPT = 40  # valid messages a stream


@cache
def traffic() -> dict[str, list[tuple[str, bytes]]]:
    """Keys and payloads of real runs with faults, by stream."""
    heard: defaultdict[str, list[tuple[str, bytes]]] = defaultdict(list)

    class Ear:
        finished, deadline = False, float("inf")

        def handle(self, event: Event) -> None:
            if isinstance(event, Sample):
                heard[event.key.rpartition("/")[2]].append((event.key, event.payload))

        def wake(self, now: float) -> None:
            """Nothing is due."""

    for scenario in (fault_scenario(1), crash(0), replace(crash(0), network=Network("near"))):
        with patch("world.shell.node.drawn_epoch", return_value=EPOCH):
            fleet = LocalFleet(scenario, speed=0.0)
        bus = fleet.network.connect()
        bus.subscribe(everything(fleet.run))
        bus.node = Ear()
        fleet.execute()
    unsaid = robot_key(fleet.run, 1, "goalstatus"), encode(ONE["goalstatus"])
    heard["goalstatus"].append(unsaid)
    assert heard.keys() == STREAMS.keys()
    return {name: sorted(all_)[:: max(1, len(all_) // _KEPT)] for name, all_ in sorted(heard.items())}
