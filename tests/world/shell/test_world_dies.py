"""The world dies at any moment, another one goes on, and nothing touches, jumps or is forgotten."""

import itertools
import math
import os
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, cast

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Bus, Event, Publish, Sample
from protocol.codec import decode
from protocol.keys import Stream, robot_key, world_key
from protocol.messages import Grants, Tick, Truth, Vector
from protocol.scenario.model import ProcessFault, Scenario
from tests.mortal import MortalFleet
from tests.proxy import Proxy
from tests.skipped_waits import skipped_waits
from tests.system.orders.test_scheduled_orders import EVERYTHING
from world.shell.checkpoint import Checkpoint
from world.shell.node import WorldNode

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


class Death(BaseException):
    """kill -9, at this very operation."""


class Doom:
    """Counts the operations by which any process can tell what a world did, and dies at some of them.

    A write of the checkpoint is three: before it, in the middle of it, after it; a publication is one.
    """

    def __init__(self, at: list[int]) -> None:
        self.at = set(at)
        self.count = itertools.count()
        self.deaths = 0

    def pass_by(self) -> None:
        if next(self.count) in self.at:
            self.deaths += 1
            raise Death

    def write(self, file: int, content: bytes, place: int) -> int:
        self.pass_by()
        half = len(content) // 2
        _pwrite(file, content[:half], place)
        self.pass_by()
        written = _pwrite(file, content[half:], place + half)
        self.pass_by()
        return half + written


_pwrite = os.pwrite


class DoomedFleet(MortalFleet):
    """A world that dies by its doom, and has a successor at once."""

    def __init__(self, scenario: Scenario, checkpoint: Path, doom: Doom, *, lockstep: bool = True) -> None:
        self.doom = doom
        super().__init__(scenario, checkpoint, lockstep=lockstep)

    def start_world(self) -> None:
        try:
            super().start_world()
            node = self.world
            self.world_bus.node = Proxy(node, handle=self._mortal(node.handle), wake=self._mortal(node.wake))
        except Death:
            self.kill_world()
            self.start_world()

    def _world(self, bus: Bus, checkpoint: Checkpoint | None = None) -> WorldNode:
        def publisher(stream: Stream, key: str) -> Publish:
            publish = bus.publisher(stream, key)

            def doomed(payload: bytes) -> None:
                self.doom.pass_by()
                publish(payload)

            return doomed

        return super()._world(cast(Bus, Proxy(bus, publisher=publisher)), checkpoint)

    def _mortal(self, act: Callable[..., None]) -> Callable[..., None]:
        def live(*told: Any) -> None:
            try:
                act(*told)
            except Death:
                self.kill_world()
                self.start_world()

        return live


class Witness:
    """Hears what all worlds of a run say, and holds them to it.

    Attributes:
        ways: length of the way of each robot, m, by what was said of where it is.
    """

    finished, deadline = False, math.inf

    def __init__(self, fleet: LocalFleet, scenario: Scenario) -> None:
        self._scenario = scenario
        self._places: dict[tuple[int, int], Vector] = {}
        self._grants: dict[tuple[int, int], tuple[int, Grants]] = {}
        bus = fleet.network.connect()
        ids = {*scenario.ids, *(spec.id for spec in scenario.newcomers)}
        bus.subscribe(world_key("local", "truth"), *[robot_key("local", robot, "tick") for robot in ids])
        bus.node = self

    def handle(self, event: Event) -> None:
        message = decode(event.key, event.payload) if isinstance(event, Sample) else None
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

    @property
    def _longest(self) -> float:
        return self._scenario.control.speed * self._scenario.time.step

    def wake(self, now: float) -> None:
        """Nothing is due by the wall clock."""


def run(name: str, folder: Path, deaths: list[int], *, lockstep: bool = True) -> tuple[Doom, dict[str, Any]]:
    """The report of a course whose world dies at these operations."""
    doom = Doom(deaths)
    with skipped_waits(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "pwrite", doom.write)
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
