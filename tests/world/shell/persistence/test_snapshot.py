"""A world that was written down and read again goes on as if nothing had been."""

from __future__ import annotations

import math
import pickle
import time
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Event
from protocol.codec import decode
from protocol.errors import JournalError
from protocol.keys import world_key
from protocol.messages import Truth
from protocol.scenario.model import ProcessFault, Scenario
from tests.world.driving import two
from world.judge import trajectory
from world.shell.persistence.journal import Journal
from world.shell.persistence.replay import resume
from world.shell.persistence.snapshot import Snapshot, frozen, is_due, restored, thawed
from world.shell.processes import Processes

NOISY = [
    "link.delay=[0.0, 0.2]", "link.loss=0.3", "sensing.noise=0.001", "sensing.delay=[0.0,0.1]",
    "actuation.noise=0.02", "control.speed=0.3",
]  # fmt: skip
KINDS = {
    "delays, noise": ("figure-3b", NOISY),
    "process faults": ("crash", ["control.speed=0.3"]),
    "parts": ("parts-3", []),
    "near ones only": ("random-40", []),
    "things": ("boxes-3", ["time.step=0.05"]),
    "wheels": ("turtlebots-3", []),
    "physics": ("turtlebots-2", ["world.plant=mujoco"]),
}


@pytest.fixture(autouse=True)
def _short_links(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trajectory, "LINK", 20)


def course(kind: str) -> Scenario:
    name, settings = KINDS[kind]
    return load(name, [*settings, "time.limit=3.5"])


def reported(scenario: Scenario, *, written_down: bool) -> tuple[dict[str, Any], int]:
    """The report of a run, and how often its world was written down and read again."""
    fleet, times = LocalFleet(scenario), 0
    while fleet.step():
        if written_down and is_due(fleet.world.world):
            fleet.world._run.world = thawed(frozen(fleet.world.world))
            times += 1
    report = fleet.execute()
    del report["wall_time"], report["messages"]
    return report, times


@pytest.mark.parametrize("kind", KINDS)
def test_it_goes_on_with_all_that_it_knew(kind: str) -> None:
    scenario = course(kind)
    found, times = reported(scenario, written_down=True)
    assert times > 1
    assert found == reported(scenario, written_down=False)[0]


def test_a_world_that_died_goes_on_from_the_newest(tmp_path: Path) -> None:
    """With who takes part, and who was ended and has not noticed yet; the journal stays short."""
    path, scenario = tmp_path / "journal", load("crash", ["time.limit=6.0"])
    Journal.create(path, "local", scenario)
    fleet, most = LocalFleet(scenario, journal=path), 0
    while fleet.world.world.tick < 70:
        assert fleet.step()
        most = max(most, path.stat().st_size)
    processes, told = fleet.world._admissions.processes.copy(), fleet.world.world.checksum
    fleet.kill_world()
    past = resume(Journal(path, "local", scenario), scenario)
    assert (past.run.world.tick, past.run.world.checksum) == (70, told)
    assert past.processes == processes
    assert isinstance(past.journal.past[0], Snapshot)
    assert past.journal.past[0].expected == {}
    assert past.run.began == pytest.approx(time.monotonic(), abs=60.0)
    assert most < 60_000


def test_watchers_are_told_every_tick_over_snapshots(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    scenario = replace(load("swap-4"), process=(ProcessFault(2, 0.5, "restart"),))
    Journal.create(path, "local", scenario)
    fleet, ticks = LocalFleet(scenario, journal=path), list[int]()

    class Watching:
        finished, deadline = False, math.inf

        def handle(self, event: Event) -> None:
            message = decode(event.key, event.payload)  # type: ignore[union-attr]
            assert isinstance(message, Truth)
            ticks.append(message.tick)

        def wake(self, now: float) -> None: ...

    bus = fleet.network.connect()
    bus.subscribe(world_key("local", "truth"))
    bus.node = Watching()
    report = fleet.execute()
    bus.drain()
    assert ticks == list(range(report["ticks"] + 1))


def test_between_two_links_of_its_digest_there_is_none() -> None:
    fleet = LocalFleet(load("swap-2"))
    assert fleet.step()
    with pytest.raises(ValueError, match="at tick 20, not at 1"):
        frozen(fleet.world.world)


class Elsewhere:
    """What a file should not be able to have made."""

    def __reduce__(self) -> tuple[Any, ...]:
        return print, ("here",)


@pytest.mark.parametrize(
    "name", ["cos", "world.shell.persistence.journal\nos.remove", "world.shell.persistence.journal\nPath"]
)
def test_what_names_anything_else_is_refused(name: str) -> None:
    module = "" if "\n" in name else "math\n"
    with pytest.raises(pickle.UnpicklingError, match="it names"):
        thawed(f"c{module}{name}\n.".encode())


def test_a_function_is_not_called() -> None:
    with pytest.raises(pickle.UnpicklingError, match=r"builtins\.print"):
        thawed(pickle.dumps(Elsewhere()))


def test_a_damaged_one_is_refused() -> None:
    with pytest.raises(pickle.UnpicklingError, match="damaged"):
        restored(Snapshot(b"any", sha256(b"other").digest(), 0.0, Processes(), {}))


@pytest.mark.parametrize("state", [b"", b"no pickle", pickle.dumps({1, 2})])
def test_what_is_no_world_is_refused_with_its_file(tmp_path: Path, state: bytes) -> None:
    path, scenario = tmp_path / "journal", two()
    Journal.create(path, "yard", scenario)
    journal = Journal(path, "yard", scenario)
    journal.compact(Snapshot(state, sha256(state).digest(), 0.0, Processes(), {}))
    journal.close()
    with pytest.raises(JournalError, match=f"{path}.*no snapshot"):
        resume(Journal(path, "yard", scenario), scenario)
