"""The world dies at any moment, another one goes on from its journal, and no trajectory shows it."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Bus, Event, Publish
from protocol.errors import JournalError
from protocol.scenario.model import ProcessFault, Scenario
from protocol.streams import Stream
from tests.world.driving import advance, two
from world.coordinator.inputs import Closed
from world.judge import trajectory
from world.shell.node import WorldNode
from world.shell.persistence import records
from world.shell.persistence.journal import Journal
from world.shell.persistence.replay import resume
from world.shell.persistence.snapshot import Snapshot

QUICK = load("swap-4", ["control.speed=0.3"])
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
COURSES = [QUICK, FAULTY]


_compact = Journal.compact


@pytest.fixture(autouse=True)
def _frequent_snapshots(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trajectory, "LINK", 40)


class Death(BaseException):
    """kill -9, at this very operation."""


class Doom:
    """Counts the operations by which anybody outside can tell what a world did, and dies at some of them.

    Each write to the journal is three: before it, in the middle of it, after it; to begin it anew with a
    snapshot is two; each publication is one.
    """

    def __init__(self, at: list[int]) -> None:
        self.at = set(at)
        self.count = itertools.count()
        self.deaths = self.snapshots = 0

    def pass_by(self) -> None:
        if next(self.count) in self.at:
            self.deaths += 1
            raise Death

    def write(self, file: int, record: bytes) -> None:
        self.pass_by()
        half = len(record) // 2
        os.write(file, record[:half])
        self.pass_by()
        os.write(file, record[half:])
        self.pass_by()

    def compact(self, journal: Journal, snapshot: Snapshot) -> None:
        self.pass_by()
        _compact(journal, snapshot)
        self.snapshots += 1
        self.pass_by()


class DoomedBus:
    """A bus whose publications pass by the doom."""

    def __init__(self, bus: Bus, doom: Doom) -> None:
        self._bus, self._doom = bus, doom

    def publisher(self, stream: Stream, key: str) -> Publish:
        publish = self._bus.publisher(stream, key)

        def doomed(payload: bytes) -> None:
            self._doom.pass_by()
            publish(payload)

        return doomed

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bus, name)


class MortalFleet(LocalFleet):
    """A world that dies by its doom, and has a successor at once."""

    def __init__(self, scenario: Scenario, journal: Path, doom: Doom, *, lockstep: bool = True) -> None:
        self.doom = doom
        Journal.create(journal, "local", scenario)
        super().__init__(scenario, journal=journal, lockstep=lockstep)

    def start_world(self) -> None:
        try:
            super().start_world()
            self.world_bus.node = Mortal(self)
        except Death:
            self.kill_world()
            self.start_world()

    def _world(self, bus: Bus) -> WorldNode:
        return super()._world(DoomedBus(bus, self.doom))


class Mortal:
    """The node of such a world."""

    def __init__(self, fleet: MortalFleet) -> None:
        self._fleet, self._node = fleet, fleet.world

    def handle(self, event: Event) -> None:
        self._live(lambda: self._node.handle(event))

    def wake(self, now: float) -> None:
        self._live(lambda: self._node.wake(now))

    def _live(self, act: Callable[[], None]) -> None:
        try:
            act()
        except Death:
            self._fleet.kill_world()
            self._fleet.start_world()

    @property
    def deadline(self) -> float:
        return self._node.deadline

    @property
    def finished(self) -> bool:
        return self._node.finished


@cache
def undisturbed(number: int) -> str:
    report = LocalFleet(COURSES[number]).execute()
    assert report["verdict"] == "arrived"
    return str(report["trajectory_sha256"])


def disturbed(
    number: int, folder: Path, deaths: list[int], *, lockstep: bool = True
) -> tuple[Doom, dict[str, Any]]:
    """The report of a course whose world dies at these operations."""
    doom = Doom(deaths)

    def compact(journal: Journal, snapshot: Snapshot) -> None:
        doom.compact(journal, snapshot)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(records, "write", doom.write)
        patch.setattr(Journal, "compact", compact)
        fleet = MortalFleet(COURSES[number], folder / "journal", doom, lockstep=lockstep)
        return doom, fleet.execute()


@cache
def operations(number: int) -> int:
    """How many there are in a course."""
    with TemporaryDirectory() as folder:
        doom, report = disturbed(number, Path(folder), [])
    assert report["trajectory_sha256"] == undisturbed(number)
    assert doom.snapshots
    return next(doom.count)


@pytest.mark.slow
@given(data=st.data(), number=st.integers(0, len(COURSES) - 1))
@settings(max_examples=40, deadline=None)
@pytest.mark.long(10)
def test_the_trajectory_is_that_of_a_run_without_deaths(data: st.DataObject, number: int) -> None:
    last = operations(number) - 1
    deaths = data.draw(st.lists(st.integers(0, last), min_size=1, max_size=3))
    with TemporaryDirectory() as folder:
        doom, report = disturbed(number, Path(folder), deaths)
    assert doom.deaths > 0 or min(deaths) > 0.9 * last  # how much is said at the end is a matter of time
    assert report["trajectory_sha256"] == undisturbed(number)
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)


@pytest.mark.slow
def test_in_real_time_ticks_go_on_from_the_journal(tmp_path: Path) -> None:
    _, report = disturbed(0, tmp_path, [200, 400], lockstep=False)
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)


def test_a_journal_that_leads_elsewhere_is_refused(tmp_path: Path) -> None:
    path, scenario = tmp_path / "journal", two()
    Journal.create(path, "yard", scenario)
    journal = Journal(path, "yard", scenario)
    journal.note(Closed(0))  # of a tick that never was
    journal.close()
    with pytest.raises(JournalError, match="leads elsewhere: entry 0"):
        resume(Journal(path, "yard", scenario), scenario)


def test_a_replay_that_ends_up_in_another_place_is_refused(tmp_path: Path) -> None:
    path, scenario = tmp_path / "journal", two()
    Journal.create(path, "yard", scenario)
    journal = Journal(path, "yard", scenario)
    world = resume(journal, scenario).run.world
    world.coordinator.note = lambda entry: journal.note(
        Closed(entry.checksum ^ 1) if isinstance(entry, Closed) else entry
    )
    for robot in (1, 2):
        world.coordinator.join(robot)
    advance(world, {1: (0.02, 0.0)})
    journal.close()
    with pytest.raises(JournalError, match="in tick 1; was it written by another version"):
        resume(Journal(path, "yard", scenario), scenario)
