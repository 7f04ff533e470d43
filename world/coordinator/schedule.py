"""What the scenario asks for at given times, as an operator would, and what came of it."""

from __future__ import annotations

from collections import deque
from typing import Protocol

from protocol.requests.goals import GoalOrder, GoalReply
from protocol.requests.things import ThingOrder, ThingReply
from protocol.scenario.model import Order, RobotSpec, Scenario, Thing


class Operated(Protocol):
    """Who carries out orders: see `world.world.World`."""

    def order(self, robot: int, order: GoalOrder) -> GoalReply: ...

    def add(self, spec: RobotSpec, *, awaited: bool = False) -> str: ...

    def remove(self, robot: int) -> str: ...

    def add_thing(self, order: ThingOrder) -> ThingReply: ...

    def remove_thing(self, number: int) -> ThingReply: ...

    def halt(self, halted: bool) -> None: ...


class Schedule:
    """The orders of a scenario, each carried out as its tick opens.

    Attributes:
        done: tick, order, and why it was refused, "" if it was not; as they came.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.done: list[tuple[int, Order, str]] = []
        due = [(scenario.ticks(order.at), order) for order in scenario.orders]
        self._due = deque(sorted(due, key=lambda entry: entry[0]))  # stable: as written within a tick

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
            self.done.append((tick, order, refusal(order, operated)))


def refusal(order: Order, operated: Operated) -> str:
    """Carry out an order; why it was refused, "" if it was not."""
    if order.goal is not None:
        goal = order.goal
        wanted = GoalOrder(goal.points, goal.queue, goal.patrol, goal.within)
        return _said(operated.order(goal.robot, wanted))
    if order.add is not None:
        return operated.add(order.add, awaited=True)
    if order.remove is not None:
        return operated.remove(order.remove)
    if order.place is not None:
        return _said(operated.add_thing(_ordered(order.place)))
    if order.take is not None:
        return _said(operated.remove_thing(order.take))
    if order.halt is not None:
        operated.halt(order.halt)
    return ""


def _ordered(thing: Thing) -> ThingOrder:
    return ThingOrder(thing.center, thing.radius, thing.points or ())


def _said(reply: GoalReply | ThingReply) -> str:
    return "" if reply.accepted else reply.text
