"""How near a run came to touching, and in which circumstances: what tells promising runs from dull ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np

from deploy.studies.falsify.runs.exposure import Sides, exposure
from protocol.messages import Truth
from protocol.scenario.model import Scenario
from world.judge.clearance import Disks, Reals, gaps
from world.judge.record import as_plane

_RESOLVED = 1e-6  # of what a robot moves in a tick: gaps below are as good as none
_EXPOSED = 1000.0  # above every other score
_MOST = 4  # changes of lives that count


@dataclass(frozen=True)
class Nearness:
    """A score, higher for nearer, and the niche in which runs compete for the highest."""

    score: float
    niche: tuple[str, ...]


def nearness(
    scenario: Scenario, truths: Sequence[Truth], sides: Sequence[Sides], faults: dict[str, Any]
) -> Nearness:
    """Of a run with these true positions, tick by tick, lines kept to, and `faults` as its report lists them.

    Where robots were not kept apart by any line the score is how far (`exposure`), above all others.
    Elsewhere it is that of the nearest miss: the smaller a gap is, beside what a robot moves in a tick, the
    higher, while one of the two moves; and higher the more lives of the two have ended or begun by then,
    for two settled robots keep touching distance as a matter of course. Against the boundary what
    counts instead, as against things, is how wrong measurements are.
    """
    exposed = exposure(scenario, truths, sides) if len(truths) > 1 else 0.0
    if exposed > _RESOLVED:
        return Nearness(_EXPOSED + math.log10(exposed / _RESOLVED), _niche(scenario, "exposed", 0))
    found = [Nearness(0.0, _niche(scenario, "nobody", 0))]
    for stretch in _stretches(truths):
        if len(stretch) > 1:
            found.append(_nearest(_at_that_time(scenario, stretch[0]), stretch, faults))
    return max(found, key=lambda each: each.score)


def _stretches(truths: Sequence[Truth]) -> Iterator[list[Truth]]:
    """Between robots that come or go."""
    for _, stretch in groupby(truths, key=lambda truth: truth.robots):
        yield list(stretch)


def _at_that_time(scenario: Scenario, truth: Truth) -> Scenario:
    """With the robots that are there then; without things, if any of them is taken away, and without
    parts, which come and go."""
    known = {spec.id: spec for spec in (*scenario.newcomers, *scenario.robots)}
    taken = any(order.take is not None for order in scenario.orders)
    robots = tuple(known[robot] for robot in truth.robots)
    return replace(scenario, robots=robots, things=() if taken else scenario.things, parts=())


def _nearest(scenario: Scenario, truths: Sequence[Truth], faults: dict[str, Any]) -> Nearness:
    """The nearest miss while the same robots are there."""
    disks = Disks(scenario)
    plane = as_plane([truth.positions for truth in truths])
    before, after = plane[:-1], plane[1:]
    reach = scenario.control.speed * scenario.time.step * (1.0 + scenario.actuation.bound)
    moved = np.abs(after - before) > _RESOLVED * reach
    near = -np.log10(np.maximum(gaps(disks, before, after), 0.0) / reach + _RESOLVED)
    changes = _changes(disks, truths[0].tick, len(before), faults)
    pairs = near[:, : len(disks.contact)] * (moved[:, disks.first] | moved[:, disks.second])
    between = changes[:, disks.first] + changes[:, disks.second]
    around = len(disks.surroundings) // len(disks.ids)
    weighed = np.concatenate(
        (
            pairs * (1.0 + np.minimum(between, _MOST)),
            near[:, len(disks.contact) :]
            * np.tile(moved * (1.0 + _wrongness(scenario, disks, reach)), around),
        ),
        axis=1,
    )
    tick, index = np.unravel_index(int(weighed.argmax()), weighed.shape)
    lives = 0 if index >= len(disks.contact) else int(between[tick, index])
    one, _ = disks.names(int(index))
    nearest = "pair" if one > 0 else "thing" if one else "wall"
    return Nearness(float(weighed[tick, index]), _niche(scenario, nearest, lives))


def _changes(disks: Disks, begin: int, ticks: int, faults: dict[str, Any]) -> Reals:
    """Of each robot, how many of its lives have ended or begun by each tick from `begin` on, shape
    (ticks, p)."""
    changes = np.zeros((ticks, len(disks.ids)))
    column = {robot: place for place, robot in enumerate(disks.ids)}
    for event in (*faults["process"], *faults["fenced"]):
        if event["robot"] in column:
            changes[max(0, event["tick"] - begin) :, column[event["robot"]]] += 1.0
    return changes


def _wrongness(scenario: Scenario, disks: Disks, reach: float) -> Reals:
    """How wrong each robot may be about its place, beside what it moves in a tick; a logarithm, 0 to 4."""
    bounds = np.array([scenario.sensing_of(robot).bound for robot in disks.ids])
    wrong: Reals = np.clip(2.0 + np.log10(bounds / reach + 1e-9), 0.0, 4.0)
    return wrong


def _niche(scenario: Scenario, nearest: str, lives: int) -> tuple[str, ...]:
    noisy = any(sensing.bound > 0.0 for sensing in scenario.sensing)
    late = scenario.link.delay not in (0.0, (0.0, 0.0)) or scenario.link.jitter > 0.0
    return (
        nearest,
        str(min(lives, _MOST)),
        scenario.control.law,
        "noise" if noisy else "exact",
        "late" if late else "prompt",
        "parted" if scenario.link.partition else "whole",
        "walls" if scenario.workspace.points else "round",
        "points" if scenario.body == "point" else "bodies",
        "orders" if scenario.orders else "",
        "parts" if scenario.parts else "",
        "near" if scenario.hears_near else "all",
        str(min(3, int(math.log2(len(scenario.robots))))),
    )
