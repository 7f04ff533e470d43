"""A message that a network loses costs a lock-step run a moment, no robot, and no bit of the trajectory."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Event, Node, Sample
from protocol.codec import decode
from protocol.messages import AnyMessage, Command, State, Tick

SCENARIO = load("swap-4")
LOST_AT = (0, 7)  # ticks


@dataclass
class Deaf:
    """A node that does not hear the first message of a kind, from any sender, at some ticks."""

    node: Node
    kind: type[Tick | State | Command]
    missed: int = 0

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample) and self._misses(decode(event.key, event.payload)):
            self.missed += 1
        else:
            self.node.handle(event)

    def _misses(self, message: AnyMessage) -> bool:
        due = LOST_AT[self.missed : self.missed + 1]
        return isinstance(message, self.kind) and message.tick in due

    def wake(self, now: float) -> None:
        self.node.wake(now)

    @property
    def deadline(self) -> float:
        return self.node.deadline

    @property
    def finished(self) -> bool:
        return self.node.finished


@pytest.mark.parametrize(("listener", "kind"), [(2, State), (2, Tick), (None, Command)])
@pytest.mark.slow
def test_what_is_lost_is_said_again(listener: int | None, kind: type[Tick | State | Command]) -> None:
    whole = LocalFleet(SCENARIO).execute()
    fleet = LocalFleet(SCENARIO)
    bus = fleet.network._buses[0] if listener is None else fleet.robots[listener]
    assert bus.node is not None
    remaining = bus.node = Deaf(bus.node, kind)
    report = fleet.execute()
    assert remaining.missed == len(LOST_AT)
    assert report["verdict"] == "arrived"
    assert report["trajectory_sha256"] == whole["trajectory_sha256"]
    assert report["ticks"] == whole["ticks"]
