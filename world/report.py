"""The result of a run as far as the world knows it, in plain types."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from protocol.scenario.model import Order, Scenario
from world.coordinator.commands import Commands
from world.coordinator.lives import Lives
from world.judge.contacts import Contact, Touches
from world.judge.measures import normalised_length, tight
from world.judge.record import Record
from world.sensing import Sensor

LISTED = 5000  # entries of a list that may grow without limit: the result is one message


def report(
    scenario: Scenario,
    *,
    verdict: tuple[str, str],
    arrived: list[int],
    record: Record,
    worlds: tuple[int, ...],
    touches: Touches,
    lengths: Mapping[int, float],
    commands: Commands,
    lives: Lives,
    sensors: Iterable[Sensor],
    orders: Iterable[tuple[int, Order, str]],
    largest_bound: float | None = None,
) -> dict[str, Any]:
    """Result fields: SI units, times in s of simulated time; None where a measure has no meaning.

    Of contacts, process faults and fences the first `LISTED` each; `collisions` counts all contacts.
    lateral_deviation: largest distance of each robot from the segment between its start and its goal.

    plant: what moved the disks, and the contacts that it reported by itself, if it can. Of bases outside
    the truth is unknown: everything here is judged by what robots reported of themselves, each time off by
    no more than `reported_bound`, m, unless a stated bound is wrong.

    Args:
        verdict: and its reason.
        arrived: ids of robots that are at their goals.
        worlds: ticks with which those worlds began that went on from others.
        lengths: path length of each robot that is or was there, m.
        orders: those of the scenario that were due: tick, order, and why it was refused or "".
        largest_bound: by which a reported position may have been off, m; None where the truth is known.
    """
    step, totals, segment = scenario.time.step, record.totals, record.segment
    truth, contacts = totals.truth, totals.contacts.all
    return {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "robots": list(scenario.ids),
        "law": scenario.control.law,
        "filter": scenario.control.filter,
        "k": scenario.k,
        "verdict": verdict[0],
        "reason": verdict[1],
        "arrived": arrived,
        "collisions": len(contacts),
        "contacts": [_contact(contact, step) for contact in contacts[:LISTED]],
        "min_clearance": totals.clearance,
        "plant": {
            "kind": scenario.world.plant,
            "contacts": [{"pair": list(pair), "tick": tick} for tick, pair in touches.all[:LISTED]],
            "reported_bound": largest_bound,
        },
        "nrl": normalised_length(segment.goals, dict(lengths)),
        "path_lengths": {str(robot): length for robot, length in sorted(lengths.items())},
        "lateral_deviation": {str(robot): deviation for robot, deviation in sorted(totals.deviation.items())},
        "tight": tight(segment.disks, segment.goals),
        "ticks": truth.tick,
        "sim_time": truth.tick * step,
        "missed_commands": commands.missed,
        "rejected_commands": dict(commands.refused),
        "down": [fenced.robot for fenced in lives.standing],
        "orders": [_order(tick, order, refused) for tick, order, refused in orders],
        "faults": _faults(scenario, lives, list(sensors)),
        "phi": {"first": totals.first.phi, "last": truth.phi, "increases": totals.increases},
        "log_potential": {"first": totals.first.log_potential, "last": truth.log_potential},
        "positions": {
            str(robot): list(position) for robot, position in zip(truth.robots, truth.positions, strict=True)
        },
        "trajectory_sha256": record.sha256(),
        "worlds": list(worlds),
    }


def _contact(contact: Contact, step: float) -> dict[str, Any]:
    return {
        "pair": list(contact.pair),
        "from": contact.begin * step,
        "until": contact.end * step,
        "deepest": contact.deepest,
    }


def _order(tick: int, order: Order, refused: str) -> dict[str, Any]:
    asked = {key: value for key, value in plain(order).items() if value is not None}
    return {**asked, "tick": tick, "refused": refused}


def _faults(scenario: Scenario, lives: Lives, sensors: list[Sensor]) -> dict[str, Any]:
    """What the scenario asked for, and what came of it."""
    return {
        "process": [{**plain(fault), "tick": tick} for tick, fault in lives.applied[:LISTED]],
        "fenced": [
            {"robot": down.robot, "incarnation": down.incarnation, "tick": tick}
            for tick, down in lives.fenced[:LISTED]
        ],
        "given_up": [
            {"robot": robot, "incarnation": incarnation, "tick": tick, "reason": reason}
            for tick, robot, incarnation, reason in lives.given_up[:LISTED]
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
