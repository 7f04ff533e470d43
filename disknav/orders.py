"""Orders to a running fleet or simulation: goals of robots, and obstacles."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from math import inf, isfinite, nan
from operator import index
from pathlib import Path
from typing import Any, SupportsFloat

from deploy.run.operator import Operator, operating
from disknav.scenarios import written
from protocol.errors import KeyGrammarError, MessageError, UsageError
from protocol.geometry import Shape
from protocol.messages import GoalStatus, Vector
from protocol.operations import read_operation

_LONGEST = 1e6  # s


def _whole(number: object) -> int:
    try:
        return index(number)  # type: ignore[arg-type]  # `index` rejects other types
    except TypeError:
        raise UsageError(f"{number!r}: give a whole number") from None


def finite(velocity: Iterable[SupportsFloat]) -> Vector:
    """A velocity, m/s, in plain numbers; raises UsageError if it is none."""
    try:
        vx, vy = map(float, velocity)
    except (TypeError, ValueError, OverflowError):
        vx = vy = nan
    if not (isfinite(vx) and isfinite(vy)):
        raise UsageError(f"velocity {velocity!r}: give two finite numbers, m/s")
    return vx, vy


class Orders:
    """Gives goals to the robots of one run, and places and removes obstacles."""

    def __init__(self, operator: Operator) -> None:
        self._operator = operator

    def send(
        self,
        robot: int,
        *points: Vector,
        queue: bool = False,
        patrol: bool = False,
        within: float | None = None,
    ) -> int:
        """Give a robot the goals `points` (m), one after another; without points, cancel its goals.

        Args:
            queue: append to its goals instead of replacing them.
            patrol: repeat the points without end.
            within: simulated s after which the robot gives up and stays.

        Returns:
            The number of the order.

        Raises:
            UsageError: the order is malformed, or the world refuses it, with the reason.
            BusError: no world of this run answers.
        """
        goal = {"robot": robot, "points": points, "queue": queue, "patrol": patrol, "within": within}
        return self._operate({"goal": goal})

    def wish(self, robot: int, velocity: Vector) -> None:
        """Set the desired velocity of a robot, m/s, if the scenario has `control.law = "external"`.

        It is limited to the speed limit, and valid for `control.lifetime`. There is no reply; the safety
        filter may reduce it.

        Raises:
            UsageError: `robot` is no valid id, or `velocity` is not two finite numbers.
        """
        try:
            self._operator.wish(_whole(robot), finite(velocity))
        except KeyGrammarError as error:
            raise UsageError(str(error)) from None

    def status(self, robot: int) -> GoalStatus | None:
        """State of a robot's order: `status`, `goal` (m), and the number of points `ahead`.

        Raises:
            UsageError: `robot` is no integer.
            BusError: no world of this run answers.
        """
        return self._operator.operate().goal(_whole(robot))

    def place(self, *points: Vector, radius: float | None = None) -> int:
        """Place a disk of `radius` (m) around a point, or the convex polygon of several points (m).

        The obstacle appears once every robot keeps clear of it.

        Returns:
            The number of the obstacle.

        Raises:
            UsageError: it is neither, or the world refuses it, with the reason.
            BusError: no world of this run answers.
        """
        if radius is None:
            return self._operate({"place": {"points": points}})
        if len(points) == 1:
            return self._operate({"place": {"center": points[0], "radius": radius}})
        raise UsageError("a disk has one point, its centre; leave out the others, or the radius")

    def take(self, number: int) -> None:
        """Remove an obstacle; raises as `place` does."""
        self._operate({"take": number})

    def obstacles(self) -> dict[int, Shape]:
        """Present obstacles by number, without those that are yet to appear."""
        there = self._operator.operate().obstacles
        return {each.number: each.shape for each in there if each.status == "standing"}

    def _operate(self, asked: dict[str, Any]) -> int:
        """Request an operation, with the checks of one from the network; returns its number."""
        try:
            operation = read_operation(json.loads(written(asked)))
        except MessageError as error:
            raise UsageError(str(error)) from None
        outcome = self._operator.operate(operation)
        if not outcome.accepted:
            raise UsageError(f"refused: {outcome.text}")
        return outcome.number


class FleetOrders(Orders):
    """Orders to a fleet with a clock of its own, with methods that wait."""

    def outcome(self, robot: int, number: int, within: float = inf) -> GoalStatus:
        """Wait at most `within` s for the end of an order, and return its last state.

        Raises:
            BusError: the order has not ended by then, or another followed.
        """
        return self._operator.outcome(_whole(robot), _whole(number), min(within, _LONGEST))

    def stands(self, number: int, within: float = inf) -> None:
        """Wait at most `within` s until an obstacle has appeared.

        Raises:
            BusError: it has not appeared by then.
        """
        self._operator.stands(_whole(number), min(within, _LONGEST))


@contextmanager
def operate(
    run: str, *, router: str | None = None, secure: str | Path | None = None, within: float = 5.0
) -> Iterator[FleetOrders]:
    """Context manager for orders to a fleet that runs elsewhere, such as one of `disknav run --keep`.

    Args:
        run: name of the run.
        router: endpoint where its router listens; tcp/127.0.0.1:7447 unless given (tls/ with `secure`).
        secure: directory of certificates, with an operator's.
        within: s to wait for the router, and for the first tick, of a fleet that has just been started.

    Raises:
        BusError: no router listens there, or no world of this run answers.
        CertificateError: the certificates are missing or not accepted.
    """
    with operating(run, router, None if secure is None else Path(secure), within) as operator:
        operator.wait_for_begin(within)
        yield FleetOrders(operator)
