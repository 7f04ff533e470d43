"""The result of a run as far as the world knows it, in plain types."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from protocol.messages import Truth
from protocol.scenario import Scenario
from world.contacts import Contact
from world.lives import Lives
from world.measures import normalised_length, tight
from world.sensing import Sensor

REFUSALS = ("late", "early", "incarnation", "fenced", "inactive", "duplicate", "unknown")
_RISE = 1e-12  # an increase of phi below this is rounding


class Ledger:
    """What adds up over a run.

    Attributes:
        refused: commands not executed, by reason (`REFUSALS`).
        missed: commands that never came, over all active robots and ticks.
        lengths: path length of each robot, m, in the order of ids.
        clearance: smallest gap so far, m.
        first, last, increases: phi at tick 0 and now, and in how many ticks it rose.
    """

    def __init__(self, robots: int) -> None:
        self.refused: Counter[str] = Counter()
        self.missed = 0
        self.lengths = [0.0] * robots
        self.clearance = math.inf
        self.first: float | None = None
        self.last = 1.0
        self.increases = 0

    def walked(self, index: int, dx: float, dy: float) -> None:
        """A robot moved by (dx, dy), m."""
        self.lengths[index] += math.hypot(dx, dy)

    def note(self, clearance: float, phi: float) -> None:
        """Clearance during the last tick and phi after it."""
        self.clearance = min(self.clearance, clearance)
        if self.first is None:
            self.first = phi
        elif phi > self.last + _RISE:
            self.increases += 1
        self.last = phi


def report(
    scenario: Scenario,
    *,
    verdict: tuple[str, str],
    arrived: list[int],
    truth: Truth,
    ledger: Ledger,
    contacts: Sequence[Contact],
    lives: Lives,
    sensors: Iterable[Sensor],
    digest: str,
) -> dict[str, Any]:
    """Result fields: SI units, times in s of simulated time; None where a measure has no meaning."""
    step = scenario.time.step
    lengths = dict(zip(scenario.ids, ledger.lengths, strict=True))
    return {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "robots": list(scenario.ids),
        "law": scenario.control.law,
        "filter": scenario.control.filter,
        "k": scenario.gain,
        "verdict": verdict[0],
        "reason": verdict[1],
        "arrived": arrived,
        "collisions": len(contacts),
        "contacts": [_contact(contact, step) for contact in contacts],
        "min_clearance": ledger.clearance,
        "nrl": normalised_length(scenario, lengths),
        "path_lengths": {str(robot): length for robot, length in lengths.items()},
        "tight": tight(scenario),
        "ticks": truth.tick,
        "sim_time": truth.tick * step,
        "missed_commands": ledger.missed,
        "rejected_commands": {
            reason: ledger.refused[reason] for reason in REFUSALS if ledger.refused[reason]
        },
        "down": [fenced.robot for fenced in lives.down],
        "faults": _faults(scenario, lives, list(sensors)),
        "phi": {"first": ledger.first, "last": ledger.last, "increases": ledger.increases},
        "positions": {
            str(robot): list(position) for robot, position in zip(truth.robots, truth.positions, strict=True)
        },
        "trajectory_sha256": digest,
    }


def _contact(contact: Contact, step: float) -> dict[str, Any]:
    return {
        "pair": list(contact.pair),
        "from": contact.begin * step,
        "until": contact.end * step,
        "deepest": contact.deepest,
    }


def _faults(scenario: Scenario, lives: Lives, sensors: list[Sensor]) -> dict[str, Any]:
    """What the scenario asked for, and what came of it."""
    return {
        "process": [{**plain(fault), "tick": tick} for tick, fault in lives.applied],
        "fenced": [
            {"robot": down.robot, "incarnation": down.incarnation, "tick": tick}
            for tick, down in lives.fenced
        ],
        "measurements": {
            "delayed": sum(sensor.delayed for sensor in sensors),
            "missing": sum(sensor.missing for sensor in sensors),
            "dropped": sum(sensor.dropped for sensor in sensors),
        },
        "sensing": plain(scenario.sensing),
        "link": plain(scenario.link),
        "actuation": plain(scenario.actuation),
    }


def plain(value: object) -> Any:
    """Dataclasses as objects, under the names of the scenario file; tuples as lists."""
    if is_dataclass(value):
        return {field.name.rstrip("_"): plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    return value
