"""What the scenario asks for at given times, as an operator would, and what came of it."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Protocol

from protocol.operations import Outcome
from protocol.scenario.model import Operation, Scenario


class Operated(Protocol):
    """Carries out operations: `world.world.World`."""

    def operate(self, operation: Operation, *, awaited: bool = False) -> Outcome: ...


class Schedule:
    """The orders of a scenario, each carried out as its tick opens.

    Attributes:
        done: tick, order, and why it was refused, "" if it was not; as they came.

    Args:
        past: of those that are done, why they were refused, "" if they were not.
    """

    def __init__(self, scenario: Scenario, past: Sequence[str] = ()) -> None:
        due = [(scenario.ticks(order.at), order) for order in scenario.orders]
        self._due = deque(sorted(due, key=lambda entry: entry[0]))  # stable: as written within a tick
        self.done = [(*self._due.popleft(), refused) for refused in past]

    @property
    def past(self) -> list[str]:
        """What another coordinator needs to go on from here."""
        return [refused for *_, refused in self.done]

    @property
    def pending(self) -> bool:
        """Whether anything is still to be asked for."""
        return bool(self._due)

    def adds(self, robot: int) -> bool:
        """Whether a robot is still to be added."""
        return any(order.add is not None and order.add.id == robot for _, order in self._due)

    def carry_out(self, tick: int, operated: Operated) -> None:
        """Ask for everything that is due by `tick`."""
        while self._due and self._due[0][0] <= tick:
            _, order = self._due.popleft()
            outcome = operated.operate(order, awaited=True)
            self.done.append((tick, order, "" if outcome.accepted else outcome.text))
