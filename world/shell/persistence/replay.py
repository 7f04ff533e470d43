"""Going on after a death: the state that a journal leads to."""

from __future__ import annotations

import pickle
import time
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from protocol.errors import JoinError, JournalError
from protocol.messages import Command
from protocol.scenario.model import Operation, Scenario
from world.coordinator.inputs import (
    Closed,
    Contested,
    Ended,
    Expected,
    GivenUp,
    Input,
    Joined,
    Lost,
    Opened,
)
from world.shell.persistence.journal import Began, Journal, Seated
from world.shell.persistence.snapshot import Snapshot, restored
from world.shell.processes import Processes
from world.shell.run import Run
from world.world import World

_TOLD = 256  # ticks after which the truths of a replay, which nobody is told again, are thrown away


class Resumed(NamedTuple):
    """Where a journal ends: the present run, the processes that were admitted, and by robot for how many next
    lives the world has waited so far. What follows is noted in the journal."""

    journal: Journal
    run: Run
    processes: Processes
    expected: Mapping[int, int]


def resume(journal: Journal, scenario: Scenario, returning: float = 0.0) -> Resumed:
    """Do again what `journal` says, and have the world note all that follows there; `returning` as before.

    Raises:
        JournalError: the journal does not lead where it says it led.
    """
    run, seated = Run(scenario, returning=returning), dict[int, str]()
    processes, expected = Processes(), Counter[int]()
    for number, entry in enumerate(journal.past):
        if isinstance(entry, Joined) and (life := run.world.coordinator.lives.of.get(entry.robot)):
            processes.admit(entry.robot, seated.get(entry.robot, ""), life.fate)
        if isinstance(entry, Snapshot):
            run.world, run.began = _restored(journal, entry), _since(entry.began)
            processes, expected = entry.processes.copy(), Counter(entry.expected)
        elif isinstance(entry, Seated):
            seated[entry.robot] = entry.session
        elif isinstance(entry, Began):
            run.began = _since(entry.at)
        elif not _follow(run.world, entry):
            raise JournalError(
                f"the journal {journal.path} leads elsewhere: entry {number}, {entry}, in tick "
                f"{run.world.tick}; was it written by another version of disknav?"
            )
        elif isinstance(entry, Expected):
            expected[entry.robot] += 1
    if journal.past:
        run.world.news()
    run.world.coordinator.note = journal.note
    return Resumed(journal, run, processes, expected)


def _since(began: float) -> float:
    """The monotonic clock's reading when the wall clock's was this, s."""
    return time.monotonic() - max(0.0, time.time() - began)


def _restored(journal: Journal, snapshot: Snapshot) -> World:
    try:
        return restored(snapshot)
    except pickle.UnpicklingError as error:
        raise JournalError(f"the journal {journal.path} cannot be gone on from: {error}") from error


def _follow(world: World, entry: Input) -> bool:
    """Give one input to the world; whether that came of it which came of it before."""
    return _FOLLOW[type(entry)](world, entry)


def _close(world: World, entry: Closed) -> bool:
    if not world.is_open:
        return False
    world.close_tick()
    if world.tick % _TOLD == 0:
        world.news()
    return world.checksum == entry.checksum


def _join(world: World, entry: Joined) -> bool:
    try:
        return world.coordinator.join(entry.robot) == entry.incarnation
    except JoinError:
        return False


def _always(do: Callable[[World, Any], object]) -> Callable[[World, Any], bool]:
    """An input that cannot come out differently."""

    def follow(world: World, entry: Any) -> bool:
        do(world, entry)
        return True

    return follow


_FOLLOW: dict[type, Callable[[World, Any], bool]] = {
    Command: lambda world, entry: world.accept(entry),
    Opened: _always(lambda world, _: world.open_tick()),
    Closed: _close,
    Joined: _join,
    Lost: _always(lambda world, entry: world.coordinator.lost(entry.robot, entry.reason)),
    Expected: lambda world, entry: world.coordinator.expect(entry.robot),
    GivenUp: _always(lambda world, entry: world.coordinator.give_up_waiting(entry.robot, entry.reason)),
    Operation: lambda world, entry: world.operate(entry).accepted,
    Contested: _always(lambda world, entry: world.contest(entry.contested)),
    Ended: _always(lambda world, entry: world.finish(entry.verdict, entry.reason)),
}
