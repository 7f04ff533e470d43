"""The world dies at any moment, another one goes on, and nothing touches, jumps or is forgotten."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.codec import decode
from protocol.keys import robot_key, world_key
from protocol.messages import Grants, Tick, Truth, Vector
from protocol.scenario.model import ProcessFault, Scenario
from tests.listening import overhear
from tests.mortal import Doom, DoomedFleet
from tests.skipped_waits import skipped_waits
from tests.system.orders.test_scheduled_orders import EVERYTHING

FAULTS = ((2, 0.2, "pause"), (2, 0.9, "resume"), (4, 0.3, "restart"), (3, 0.25, "pause"), (3, 0.5, "resume"))
FAULTY = replace(
    load(
        "figure-3b",
        ["link.delay=[0.0, 0.2]", "link.loss=0.3", "sensing.noise=0.001", "sensing.delay=[0.0,0.1]",
         "actuation.noise=0.02", "control.speed=0.3", "time.fence=0.3"],
        5,
    ),
    process=tuple(ProcessFault(*event) for event in FAULTS),  # type: ignore[arg-type]
)  # fmt: skip
COURSES = {
    "quick": load("swap-4", ["control.speed=0.3"]),
    "faulty": FAULTY,
    "orders": EVERYTHING,
    "parts": load("parts-3"),
    "wheels": load("turtlebots-4"),
    "near": load("swap-6", ["control.speed=0.3", "network.interest=near"]),
}


class Witness:
    """Hears what all worlds of a run say, and holds them to it."""

    def __init__(self, fleet: LocalFleet, scenario: Scenario) -> None:
        self._longest = scenario.control.speed * scenario.time.step  # m, of a step
        self._places: dict[tuple[int, int], Vector] = {}
        self._grants: dict[tuple[int, int], tuple[int, Grants]] = {}
        ids = {*scenario.ids, *(spec.id for spec in scenario.newcomers)}
        keys = [world_key("local", "truth"), *(robot_key("local", robot, "tick") for robot in ids)]
        overhear(fleet.network, self._hear, *keys)

    def _hear(self, key: str, payload: bytes) -> None:
        message = decode(key, payload)
        if isinstance(message, Truth):
            for robot, place in zip(message.robots, message.positions, strict=True):
                assert self._places.setdefault((message.tick, robot), place) == place
                before = self._places.get((message.tick - 1, robot), place)
                assert math.dist(before, place) <= 2.0 * self._longest, (message.tick, robot)
        elif isinstance(message, Tick) and message.grants is not None:
            grants, life = message.grants, (message.robot, message.incarnation)
            epoch, before = self._grants.get(life, (message.epoch, grants))
            assert epoch == message.epoch, "a life has one coordinator"
            assert grants.version >= before.version
            self._grants[life] = epoch, grants


def run(name: str, folder: Path, deaths: list[int], *, lockstep: bool = True) -> tuple[Doom, dict[str, Any]]:
    """The report of a course whose world dies at these operations."""
    doom = Doom(deaths)
    with skipped_waits(), doom.in_force():
        fleet = DoomedFleet(COURSES[name], folder / "checkpoint", doom, lockstep=lockstep)
        Witness(fleet, COURSES[name])
        return doom, fleet.execute()


@cache
def undisturbed(name: str) -> tuple[int, dict[str, Any]]:
    """How many operations there are in a course, and its report."""
    with TemporaryDirectory() as folder:
        doom, report = run(name, Path(folder), [])
    plain = LocalFleet(COURSES[name]).execute()
    assert report["trajectory_sha256"] == plain["trajectory_sha256"]  # to keep a checkpoint changes nothing
    assert (report["verdict"], report["worlds"]) == ("arrived", [])
    return next(doom.count), report


def check(name: str, doom: Doom, report: dict[str, Any]) -> None:
    _, calm = undisturbed(name)
    assert (report["verdict"], report["collisions"]) == ("arrived", 0), report["reason"]
    assert len(report["worlds"]) <= doom.deaths
    assert report["worlds"] == sorted(report["worlds"])
    assert report["orders"] == calm["orders"]
    assert report["faults"]["process"] == calm["faults"]["process"]
    assert report["min_clearance"] > 0.0
    assert report["phi"]["first"] == calm["phi"]["first"]
    for spec in COURSES[name].robots:
        if str(spec.id) in report["positions"]:
            straight = math.dist(spec.start, report["positions"][str(spec.id)])
            assert report["path_lengths"][str(spec.id)] >= straight - 1e-9


def died(name: str, draw: Random) -> tuple[Doom, dict[str, Any]]:
    """A course whose world dies up to three times, and what came of it."""
    last = undisturbed(name)[0] - 1
    deaths = [draw.randint(0, last) for _ in range(draw.randint(1, 3))]
    with TemporaryDirectory() as folder:
        return run(name, Path(folder), deaths)


@pytest.mark.slow
@pytest.mark.parametrize("name", COURSES)
def test_another_world_goes_on(name: str) -> None:
    for seed in range(2):  # the campaign `worlds` goes on
        check(name, *died(name, Random(seed)))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["quick", pytest.param("wheels", marks=pytest.mark.campaign)])
def test_in_real_time_too(name: str, tmp_path: Path) -> None:
    doom, report = run(name, tmp_path, [200, 900], lockstep=False)
    assert (report["verdict"], report["collisions"], len(report["worlds"])) == ("arrived", 0, doom.deaths)
