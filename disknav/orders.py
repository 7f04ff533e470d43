"""Orders while robots drive, to them and about what stands in their way: of a fleet that runs elsewhere, or
of a simulation."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Any

from deploy.run.operator import Operator, operating
from deploy.security.membership import Membership
from deploy.security.roster import OPERATOR
from disknav.scenarios import written
from protocol.errors import MessageError, UsageError
from protocol.geometry import Shape
from protocol.messages import GoalStatus, Vector
from protocol.operations import read_operation

_LONGEST = 1e6  # s


class Orders:
    """Sends robots of one run elsewhere, and says what comes into their way and goes."""

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
        """Send a robot to `points` (m), one after another; without any, it stays where it is.

        Args:
            queue: after what it is doing, instead of at once.
            patrol: round and round through all points.
            within: s of simulated time after which it gives up and stays where it is.

        Returns:
            The number of the order.

        Raises:
            UsageError: the order is malformed, or the world refuses it; says why.
            BusError: no world of this run answers.
        """
        goal = {"robot": robot, "points": points, "queue": queue, "patrol": patrol, "within": within}
        return self._operate({"goal": goal})

    def wish(self, robot: int, velocity: Vector) -> None:
        """Say how a robot is to move from now on (m/s), if the scenario has `control.law = "external"`.

        It counts for `control.lifetime`; what is faster than the speed limit is slowed down to that. Nothing
        answers: what the robot does is what the safety filter leaves of it.
        """
        self._operator.wish(robot, (float(velocity[0]), float(velocity[1])))

    def status(self, robot: int) -> GoalStatus | None:
        """How things stand with a robot: `status`, `goal` (m), and how many points are `ahead`."""
        return self._operator.operate().goal(robot)

    def place(self, *points: Vector, radius: float | None = None) -> int:
        """Have a disk of `radius` (m) around a point appear, or the convex polygon of several, once every
        robot keeps clear of its place. Its number.

        Raises:
            UsageError: it is no such thing, or the world refuses it; says why.
            BusError: no world of this run answers.
        """
        if radius is None:
            return self._operate({"place": {"points": points}})
        if len(points) == 1:
            return self._operate({"place": {"center": points[0], "radius": radius}})
        raise UsageError("a disk has one point, its centre; leave out the others, or the radius")

    def take(self, number: int) -> None:
        """Say that a thing is not there any more; raises as `place` does."""
        self._operate({"take": number})

    def things(self) -> dict[int, Shape]:
        """What stands, by number; what is yet to appear is not among it."""
        there = self._operator.operate().things
        return {each.number: each.shape for each in there if each.status == "standing"}

    def _operate(self, asked: dict[str, Any]) -> int:
        """Ask for an operation, which is checked as if it had come over the network; its number."""
        try:
            operation = read_operation(json.loads(written(asked)))
        except MessageError as error:
            raise UsageError(str(error)) from None
        outcome = self._operator.operate(operation)
        if not outcome.accepted:
            raise UsageError(f"refused: {outcome.text}")
        return outcome.number


class FleetOrders(Orders):
    """Orders to a fleet that drives by itself, so that their end can be waited for."""

    def outcome(self, robot: int, number: int, within: float = inf) -> GoalStatus:
        """Wait until an order has come to an end, at most `within` s; how it ended.

        Raises:
            BusError: it has not.
        """
        return self._operator.outcome(robot, number, min(within, _LONGEST))

    def stands(self, number: int, within: float = inf) -> None:
        """Wait until a thing stands in its place, at most `within` s.

        Raises:
            BusError: it does not.
        """
        self._operator.stands(number, min(within, _LONGEST))


@contextmanager
def operate(
    run: str, *, router: str | None = None, secure: str | Path | None = None
) -> Iterator[FleetOrders]:
    """Inside, orders to a fleet that runs elsewhere, such as one of `disknav run --keep`.

    Args:
        run: its name.
        router: endpoint where its router listens; tcp/127.0.0.1:7447 unless given (tls/ with `secure`).
        secure: directory of certificates, with an operator's.

    Raises:
        BusError: nobody listens there.
        CertificateError: the certificates are missing or not accepted.
    """
    membership = Membership(None if secure is None else Path(secure))
    connection = membership.client(OPERATOR, (router or membership.default_router,))
    with operating(connection, membership.run(run) or run) as operator:
        yield FleetOrders(operator)
