"""Recordings read back: the scenario, the result and everything that was said, as messages and arrays."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import msgspec
import numpy as np

from deploy.recording.form import from_object
from deploy.recording.mcap.contents import Contents, contents
from deploy.recording.result import LAUNCH
from protocol.errors import KeyGrammarError, RecordingError
from protocol.keys import Address, parse
from protocol.messages import Clock, Command, Health, Message, State, Tick, Truth
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


@dataclass(frozen=True)
class Truths:
    """What was true at the start of `ticks`: positions (tick, robot, 2), m, robots in the order of ids."""

    ticks: np.ndarray
    positions: np.ndarray
    clearance: np.ndarray  # m, smallest gap during the tick before
    phi: np.ndarray

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
        entries: all messages, by time and, within one tick, as they arrived.
        cut: the file was cut short or is damaged; everything before is there.
    """

    path: Path
    run: str
    scenario: Scenario
    result: dict[str, Any] | None
    entries: list[Entry]
    truths: Truths
    cut: bool

    @property
    def clocks(self) -> list[Clock]:
        """The world's clock."""
        return [entry.message for entry in self.entries if isinstance(entry.message, Clock)]

    @property
    def told(self) -> dict[int, list[Tick]]:
        """What each robot was told, by robot."""
        return self._by_robot(Tick)

    @property
    def states(self) -> dict[int, list[State]]:
        """What each robot told its peers, by robot."""
        return self._by_robot(State)

    @property
    def commands(self) -> dict[int, list[Command]]:
        """What each robot commanded, by robot."""
        return self._by_robot(Command)

    @property
    def health(self) -> dict[int, list[Health]]:
        """What each robot said about itself, by robot."""
        return self._by_robot(Health)

    def counts(self) -> Counter[str]:
        """Messages by key."""
        return Counter(entry.key for entry in self.entries)

    def _by_robot(self, kind: type[_M]) -> dict[int, list[_M]]:
        found: dict[int, list[_M]] = {robot: [] for robot in self.scenario.ids}
        for entry in self.entries:
            if isinstance(entry.message, kind):
                found[entry.message.robot].append(entry.message)  # type: ignore[attr-defined]  # all four have it
        return found


def read(path: Path | str, progress: Progress | None = None) -> Recording:
    """Read a recording, whole or cut; `progress` is told how much is done, from 0 to 1.

    Raises:
        UsageError: there is no such file.
        RecordingError: it is not a recording of a run.
    """
    path = Path(path)
    found = contents(path)
    scenario, run = _scenario(path, found), found.metadata.get("run", {}).get("name", "")
    result = found.metadata.get(LAUNCH) or found.metadata.get("result")
    try:
        entries = list(_entries(found, progress))
        truths = _truths(scenario, entries)
        report = None if result is None else json.loads(result["json"])
    except (KeyError, ValueError, KeyGrammarError) as error:
        reason = f"{path} was written by another version, a message lacks or has too much: {error}"
        raise RecordingError(f"{reason}; read it with the version that wrote it") from error
    return Recording(
        path, run, scenario, report, entries, truths, found.cut or "recorder" not in found.metadata
    )


def _scenario(path: Path, found: Contents) -> Scenario:
    try:
        return msgspec.json.decode(found.metadata["scenario"]["json"], type=Scenario)
    except KeyError:
        what = "was cut before it began" if found.cut else "holds no scenario, so disknav did not write it"
        raise RecordingError(f"{path} {what}: there is nothing to show") from None
    except msgspec.MsgspecError as error:
        raise RecordingError(f"{path}: its scenario cannot be read by this version: {error}") from error


def _entries(found: Contents, progress: Progress | None) -> Iterator[Entry]:
    addresses: dict[int, Address] = {number: parse(topic) for number, topic in found.topics.items()}
    total = len(found.messages)
    for index, recorded in enumerate(found.messages):
        stream = STREAMS[addresses[recorded.channel_id].stream]
        message = from_object(stream.message, msgspec.json.decode(recorded.data))
        yield Entry(recorded.log_time / 1e9, found.topics[recorded.channel_id], message)
        if progress is not None and index % 4096 == 0:
            progress(index / total)


def _truths(scenario: Scenario, entries: list[Entry]) -> Truths:
    said = {entry.message.tick: entry.message for entry in entries if isinstance(entry.message, Truth)}
    said.setdefault(0, World(scenario).truth)  # what the scenario says before anybody moved
    told = [said[tick] for tick in sorted(said)]
    return Truths(
        np.array([truth.tick for truth in told]),
        np.array([truth.positions for truth in told]),
        np.array([truth.clearance for truth in told]),
        np.array([truth.phi for truth in told]),
    )
