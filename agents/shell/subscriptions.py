"""Subscriptions of one robot's process to States, and their decoders."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, final

from agents.peers.state import PeerReader, plausible
from protocol.bus.bus import Bus
from protocol.joining import Admission
from protocol.keys import robot_key

_TURNS: Final = 4  # ticks over which robots spread the end of subscriptions, which load a router


@final
class Subscriptions:
    """Subscriptions to the States of all peers, or of near ones."""

    def __init__(self, bus: Bus, run: str, robot: int) -> None:
        self.readers: dict[str, PeerReader] = {}  # by the key of the State
        self._bus, self._run, self._robot = bus, run, robot
        self._epoch = 0  # of the coordinator
        self._near: frozenset[int] = frozenset()  # peers near now or soon; empty before the first `attend`
        self._kept: frozenset[int] | None = None  # they and those near before, from `attend` to `apply`
        self._dropped: set[str] = set()  # keys to withdraw from
        self._subscribed: set[str] = set()  # keys that are subscribed to: a later life may know of more peers

    def begin(self, admission: Admission) -> None:
        """Begin a life: subscribe to all peers, unless the world will name the near ones."""
        scenario = admission.scenario
        self._limits, self._epoch = plausible(scenario), admission.epoch
        self._near, self._kept, self._dropped, self.readers = frozenset(), None, set(), {}
        if not scenario.hears_near:
            self.subscribe(scenario.ids)

    def subscribe(self, robots: Iterable[int]) -> None:
        """Subscribe to all of some robots that are peers."""
        keys = {self._key(robot): robot for robot in robots if robot != self._robot}
        for key, peer in keys.items():
            if key not in self.readers:
                self.readers[key] = PeerReader(self._robot, peer, self._epoch, self._limits)
        self._bus.subscribe(*[key for key in keys if key not in self._subscribed])
        self._subscribed.update(keys)

    def attend(self, near: Iterable[int]) -> None:
        """Set the peers that are near now or soon; `apply` applies it."""
        before, self._near = self._near, frozenset(near)
        self._kept = before | self._near

    def apply(self, tick: int) -> None:
        """Once a tick, when no peer waits for this robot: subscribe to near peers; in later ticks, which
        differ by robot, withdraw from others."""
        if self._kept is not None:
            self.subscribe(sorted(self._near))
            self._dropped = self._subscribed - {self._key(peer) for peer in self._kept}
            self._kept = None
        elif self._dropped and (tick + self._robot) % _TURNS == 0:
            for key in sorted(self._dropped):
                self._bus.unsubscribe(key)
                self._subscribed.discard(key)
                self.readers.pop(key, None)
            self._dropped = set()

    def _key(self, peer: int) -> str:
        return robot_key(self._run, peer, "state")
