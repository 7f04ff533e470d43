"""One run within this process, watched, and what no run may show."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from deploy.run.local import LocalFleet
from protocol.bus.local import LocalNetwork
from protocol.codec import decode
from protocol.keys import every_robot
from protocol.messages import Command, Health, State
from protocol.scenario.model import Scenario
from tests.drawn_order import DrawnNetwork, ReorderedFleet
from tests.listening import overhear
from tests.mortal import Doom, DoomedFleet
from tests.skipped_waits import skipped_waits

PATIENCE = 120.0  # s, skipped waits included, that a run may take; the world itself gives up sooner
_CUT = "interrupted"  # verdict of a run that exceeds it
_HOLDUP, _HOLDUPS = 0.7, 80  # s after which a tick is told again; most of them in a run
_OFTEN = 0.05  # of the messages after which the machine is busy
_EXPECTED = "down for good"  # the one reason for which the judge aborts
_REFUTED = "a stated bound is wrong"
_CONTACTS = {1: "contact", 0: "wall", -1: "obstacle"}


class Violation(NamedTuple):
    """What no run may show, whatever its scenario.

    kind: contact, wall, obstacle (a robot overlaps a robot, the boundary, an obstacle); aborted (the world
    gives up although every robot may come back); endless; contradiction (a robot knows that a bound is
    wrong, though all bounds hold); order (the trajectory depends on the order in which robots join); bus
    (the trajectory on real processes differs).
    """

    kind: str
    text: str


@dataclass(frozen=True)
class Observation:
    report: dict[str, Any]
    notes: dict[int, str]  # by robot, of what it notices about itself

    @property
    def trajectory(self) -> str:
        return str(self.report["trajectory_sha256"])

    @property
    def violations(self) -> list[Violation]:
        """What is wrong with the run, if all stated bounds hold."""
        told = [f"robot {robot}: {note}" for robot, note in self.notes.items() if _REFUTED in note]
        return [*violations(self.report), *(Violation("contradiction", each) for each in told[:1])]


def observe(
    scenario: Scenario, joining: Sequence[int] = (), *, busy: int = 0, deaths: Sequence[int] = ()
) -> Observation:
    """Run a scenario (k a number).

    Args:
        joining: the order in which robots join; by id unless given.
        deaths: operations of the world at which it dies; none if robots join in another order.
        busy: seeds the moments at which the machine is so busy that the world has the open tick said again,
            and the order in which messages arrive; 0: never, and as they were published.
    """
    doom = Doom(deaths)
    with skipped_waits(), doom.in_force(), TemporaryDirectory() as folder:
        network = DrawnNetwork(Random(busy)) if busy else LocalNetwork()
        if joining:
            fleet = ReorderedFleet(scenario, joining, network=network)
        elif deaths:
            fleet = DoomedFleet(scenario, Path(folder) / "checkpoint", doom, network=network)
        else:
            fleet = LocalFleet(scenario, network=network)
        watch, deadline = Watch(fleet, busy), time.monotonic() + PATIENCE
        network.run(lambda: fleet.world.finished or time.monotonic() > deadline)
        fleet.world.interrupt(_CUT, f"has not ended within {PATIENCE:g} s")
        watch.bus.drain()
    return Observation(fleet.report, watch.notes)


def violations(report: Mapping[str, Any]) -> list[Violation]:
    """What is wrong with a run, by its report (in plain types, as the world writes it)."""
    assert math.isfinite(report["min_clearance"])
    found = [
        _deepest(kind, contacts)
        for sign, kind in _CONTACTS.items()
        if (contacts := [each for each in report["contacts"] if np.sign(each["pair"][0]) == sign])
    ]
    if report["verdict"] == "aborted" and _EXPECTED not in report["reason"]:
        found.append(Violation("aborted", report["reason"]))
    if report["verdict"] == _CUT:
        found.append(Violation("endless", report["reason"]))
    return found


def _deepest(kind: str, contacts: Sequence[Mapping[str, Any]]) -> Violation:
    worst = min(contacts, key=lambda contact: float(contact["deepest"]))
    pair = " and ".join(map(str, worst["pair"]))
    when = f"{worst['from']:.6g} to {worst['until']:.6g} s"
    return Violation(kind, f"{pair} overlap by {-worst['deepest']:.3g} m, {when}")


class Watch:
    """Notes what robots notice about themselves, and at times has the machine be busy.

    Args:
        busy: see `observe`.
    """

    def __init__(self, fleet: LocalFleet, busy: int) -> None:
        self.notes: dict[int, str] = {}
        self._fleet, self._moments = fleet, Random(busy) if busy else None
        self._holdups, self._held_up = _HOLDUPS, -1
        streams = ("health", "state", "command") if busy else ("health",)
        keys = [every_robot(fleet.run, stream) for stream in streams]
        self.bus = overhear(fleet.network, self._hear, *keys)

    def _hear(self, key: str, payload: bytes) -> None:
        message = decode(key, payload)
        if isinstance(message, Health) and message.note:
            self.notes[message.robot] = message.note
        if self._moments is not None and isinstance(message, State | Command):
            self._hold_up(self._moments)

    def _hold_up(self, moments: Random) -> None:
        """Let time pass in the middle of a tick; once in a tick, so that no robot is given up."""
        tick = self._fleet.world.world.tick  # the message may be of an earlier one
        if tick > self._held_up and self._holdups and moments.random() < _OFTEN:
            self._held_up, self._holdups = tick, self._holdups - 1
            time.sleep(_HOLDUP)
            self._fleet.world_bus.node.on_timer(time.monotonic())
