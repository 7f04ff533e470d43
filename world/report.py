"""The world's result of a run, in plain types."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

from protocol.messages import LISTED
from protocol.scenario.model import Order, Scenario
from world.coordinator.lives import Lives
from world.judge.measures import normalised_length, tight
from world.world import WorldCore


def result_of(world: WorldCore) -> dict[str, Any]:
    """Result fields, as docs/reference/result.md has them: SI units, times in s of simulated time; None where
    a measure has no meaning. Of contacts, process faults and fences the first `LISTED` each."""
    scenario, referee = world.scenario, world.referee
    step, totals, segment = scenario.time.step, referee.record.totals, referee.record.segment
    truth, lengths = totals.truth, world.simulation.lengths
    return {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "robots": list(scenario.ids),
        "law": scenario.control.law,
        "filter": scenario.control.filter,
        "k": scenario.k,
        "verdict": referee.verdict,
        "reason": referee.reason,
        "arrived": referee.arrived(world.simulation.plant.positions),
        "collisions": totals.collisions,
        "contacts": [
            {
                "pair": list(each.pair),
                "from": each.begin * step,
                "until": each.end * step,
                "deepest": each.deepest,
            }
            for each in totals.contacts
        ],
        "min_clearance": totals.clearance,
        "plant": {
            "kind": scenario.world.plant,
            "contacts": [{"pair": list(pair), "tick": tick} for tick, pair in totals.touches],
            "reported_bound": world.simulation.largest_bound,
        },
        "nrl": normalised_length(segment.goals, lengths),
        "path_lengths": {str(robot): length for robot, length in sorted(lengths.items())},
        "lateral_deviation": {str(robot): deviation for robot, deviation in sorted(totals.deviation.items())},
        "tight": tight(segment.disks, segment.goals),
        "ticks": truth.tick,
        "sim_time": truth.tick * step,
        "missed_commands": world.exchange.missed,
        "rejected_commands": dict(world.exchange.refused),
        "down": [fenced.robot for fenced in world.lives.roster.standing],
        "orders": [_order(tick, order, refused) for tick, order, refused in world.schedule.done],
        "faults": _faults(scenario, world.lives, world.simulation.measurements),
        "phi": {"first": totals.first.phi, "last": truth.phi, "increases": totals.increases},
        "log_potential": {"first": totals.first.log_potential, "last": truth.log_potential},
        "positions": {
            str(robot): list(position) for robot, position in zip(truth.robots, truth.positions, strict=True)
        },
        "trajectory_sha256": referee.record.sha256(),
        "worlds": list(referee.worlds),
    }


def _order(tick: int, order: Order, refused: str) -> dict[str, Any]:
    asked = {key: value for key, value in plain(order).items() if value is not None}
    return {**asked, "tick": tick, "refused": refused}


def _faults(scenario: Scenario, lives: Lives, measurements: dict[str, int]) -> dict[str, Any]:
    return {
        "process": [{**plain(fault), "tick": tick} for tick, fault in lives.applied[:LISTED]],
        "fenced": [
            {"robot": down.robot, "incarnation": down.incarnation, "tick": tick}
            for tick, down in lives.fenced
        ],
        "given_up": [
            {"robot": robot, "incarnation": incarnation, "tick": tick, "reason": reason}
            for tick, robot, incarnation, reason in lives.given_up
        ],
        "measurements": measurements,
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
