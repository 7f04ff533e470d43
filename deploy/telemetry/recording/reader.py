"""Recordings read back: the scenario, the result and everything that was said, as messages and arrays.

Messages are read from the file whenever they are gone through, never all at once: what stays in memory is
where the disks were, about 20 bytes a robot and tick.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import msgspec
import numpy as np

from deploy.telemetry.recording.contents import Contents
from deploy.telemetry.recording.form import from_object
from protocol.codec import DAMAGED
from protocol.errors import KeyGrammarError, RecordingError, ScenarioError
from protocol.keys import parse, world_key
from protocol.messages import Message, Truth
from protocol.scenario.file import validated
from protocol.scenario.model import Scenario
from protocol.streams import STREAMS
from world.world import World

_M = TypeVar("_M", bound=Message)
Progress = Callable[[float], None]


class Entry(NamedTuple):
    """One recorded message: simulated time, s, and what was published under which key."""

    time: float
    key: str
    message: Message


class Entries:
    """All messages by time and, within one tick, as they arrived; every loop reads the file anew.

    Raises:
        RecordingError: (loops) a message lacks or has too much: another version wrote it.
    """

    def __init__(self, found: Contents, keep: Callable[[Entry], bool] = lambda _: True) -> None:
        self._found, self._keep = found, keep

    def __iter__(self) -> Iterator[Entry]:
        return self.of(Message)

    def of(self, *kinds: type[Message]) -> Iterator[Entry]:
        """Those of these kinds alone, which is quicker: no other is decoded."""
        wanted: dict[str, type[Message] | None] = {}  # by key
        for key, time, data in self._found.messages():
            with _by_this_version(self._found.path):
                if key not in wanted:
                    kind = STREAMS[parse(key).stream].message
                    wanted[key] = kind if issubclass(kind, kinds) else None
                if (kept := wanted[key]) is None:
                    continue
                message = from_object(kept, msgspec.json.decode(data))
            entry = Entry(time / 1e9, key, message)
            if self._keep(entry):
                yield entry

    def where(self, keep: Callable[[Entry], bool]) -> Entries:
        """Some of them."""
        return Entries(self._found, lambda entry: self._keep(entry) and keep(entry))


class Said(NamedTuple):
    """A `Truth` in few bytes: clearance, phi, log_potential, x, y, x, y, ..."""

    tick: int
    robots: tuple[int, ...]
    numbers: np.ndarray

    @classmethod
    def of(cls, truth: Truth) -> Said:
        """The same."""
        places = chain.from_iterable(truth.positions)
        return cls(
            truth.tick, truth.robots, np.array([truth.clearance, truth.phi, truth.log_potential, *places])
        )


@dataclass(frozen=True)
class Truths:
    """What was true at the start of `ticks`: positions (tick, robot, 2), m, of all `robots` that ever were
    there, in the order of ids; NaN where the disk of one was not."""

    robots: np.ndarray
    ticks: np.ndarray
    positions: np.ndarray
    clearance: np.ndarray  # m, smallest gap during the tick before
    phi: np.ndarray
    log_potential: np.ndarray

    @classmethod
    def of(cls, said: Iterable[Said]) -> Truths:
        """What the world said, in the order of ticks."""
        rows = list(said)
        robots = np.array(sorted(set(chain.from_iterable({row.robots for row in rows}))), dtype=np.int64)
        positions = np.full((len(rows), len(robots), 2), np.nan)
        for places, row in zip(positions, rows, strict=True):
            places[np.searchsorted(robots, row.robots)] = row.numbers[3:].reshape(-1, 2)
        measured = np.array([row.numbers[:3] for row in rows]).reshape(-1, 3).T
        return cls(robots, np.array([row.tick for row in rows]), positions, *measured)

    @property
    def missing(self) -> int:
        """How many ticks were not recorded, from tick 0 to the last one that was."""
        return int(self.ticks[-1]) + 1 - len(self.ticks) if len(self.ticks) else 0


@dataclass(frozen=True)
class Recording:
    """A run as it was recorded.

    Attributes:
        run: name of the run.
        result: what `disknav run --json` writes, or what the world knew of it; None when the recording
            ended before that.
        counts: messages by key.
        preceding: name of the file that this one goes on from; empty if it begins with the run.
        cut: a file was cut short, is damaged or lacks its next, or the disk was full; the rest is there.
    """

    path: Path
    run: str
    scenario: Scenario
    result: dict[str, Any] | None
    entries: Entries
    counts: Counter[str]
    truths: Truths
    preceding: str
    cut: bool

    def said(self, kind: type[_M]) -> Iterator[_M]:
        """All messages of a kind, one after the other."""
        for entry in self.entries.of(kind):
            assert isinstance(entry.message, kind)
            yield entry.message


def read(path: Path | str, progress: Progress = lambda _: None) -> Recording:
    """Read a recording, whole or cut, with the files that follow it; `progress` is told how much is done.

    Raises:
        UsageError: there is no such file.
        RecordingError: it is not a recording of a run.
    """
    path = Path(path)
    found = Contents(path)
    scenario, said = _scenario(path, found), found.metadata.get("run", {})
    run, preceding = said.get("name", ""), said.get("preceding", "")
    result = found.metadata.get("result")
    with _by_this_version(path):
        counts, truths = _looked_through(found, scenario, not preceding, progress)
        report = None if result is None else json.loads(result["json"])
    recorder = found.metadata.get("recorder")
    cut = found.cut or recorder is None
    return Recording(path, run, scenario, report, Entries(found), counts, truths, preceding, cut)


@contextmanager
def _by_this_version(path: Path) -> Iterator[None]:
    try:
        yield
    except (KeyError, ValueError, KeyGrammarError) as error:
        reason = f"{path} was written by another version, a message lacks or has too much: {error}"
        raise RecordingError(f"{reason}; read it with the version that wrote it") from error


def _scenario(path: Path, found: Contents) -> Scenario:
    try:
        scenario = validated(msgspec.json.decode(found.metadata["scenario"]["json"], type=Scenario))
        _ = scenario.k  # a number, in all that was run
        return scenario
    except KeyError:
        what = "was cut before the run began" if found.cut else "holds no scenario: disknav did not write it"
        raise RecordingError(f"{path} {what}; nothing was recorded") from None
    except (*DAMAGED, ScenarioError) as error:
        raise RecordingError(f"{path}: its scenario cannot be read by this version: {error}") from error


def _looked_through(
    found: Contents, scenario: Scenario, whole: bool, progress: Progress
) -> tuple[Counter[str], Truths]:
    counts: Counter[str] = Counter()
    said: dict[int, Said] = {}
    robots: tuple[int, ...] = ()
    truths = world_key(found.metadata.get("run", {}).get("name", ""), "truth")
    for key, _, data in found.messages(progress):
        counts[key] += 1
        if key == truths:
            truth = from_object(Truth, msgspec.json.decode(data))
            assert isinstance(truth, Truth)
            robots = robots if truth.robots == robots else truth.robots  # one tuple for all the same
            said[truth.tick] = Said.of(truth)._replace(robots=robots)
    if whole or not said:
        said.setdefault(0, Said.of(World(scenario).truth))  # what the scenario says before anybody moved
    return counts, Truths.of(said[tick] for tick in sorted(said))
