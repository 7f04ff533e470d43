"""Orders while robots drive, to them and about what stands in their way: of a fleet that runs elsewhere, or
of a simulation."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Any

import msgspec

from deploy.run.operator import Operator, operating
from deploy.security.membership import Membership
from deploy.security.roster import OPERATOR
from disknav.scenarios import written
from protocol.errors import UsageError
from protocol.geometry import Shape
from protocol.messages import GoalStatus, Id, Vector
from protocol.requests.goals import GoalOrder
from protocol.requests.things import ThingOrder, ThingReply

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
        order = _converted(
            {"points": points, "queue": queue, "patrol": patrol, "within": within}, GoalOrder, "order"
        )
        reply = self._operator.order(_converted(robot, Id, "robot"), order)
        if not reply.accepted:
            raise UsageError(f"robot {robot} cannot be sent there: {reply.text}")
        return reply.number

    def status(self, robot: int) -> GoalStatus | None:
        """How things stand with a robot: `status`, `goal` (m), and how many points are `ahead`."""
        return self._operator.status(_converted(robot, Id, "robot")).status

    def place(self, *points: Vector, radius: float | None = None) -> int:
        """Have a disk of `radius` (m) around a point appear, or the convex polygon of several, once every
        robot keeps clear of its place. Its number.

        Raises:
            UsageError: it is no such thing, or the world refuses it; says why.
            BusError: no world of this run answers.
        """
        if radius is None:
            wanted: dict[str, object] = {"points": points}
        elif len(points) == 1:
            wanted = {"center": points[0], "radius": radius}
        else:
            raise UsageError("a disk has one point, its centre; leave out the others, or the radius")
        thing = _converted(wanted, ThingOrder, "thing")
        if problem := thing.defect():
            raise UsageError(f"that is no thing: it {problem}")
        return _accepted(self._operator.place(thing))

    def take(self, number: int) -> None:
        """Say that a thing is not there any more; raises as `place` does."""
        _accepted(self._operator.take(_converted(number, Id, "number of a thing")))

    def things(self) -> dict[int, Shape]:
        """What stands, by number; what is yet to appear is not among it."""
        return {
            each.number: each.shape for each in self._operator.things().things if each.status == "standing"
        }


def _converted(value: object, kind: Any, what: str) -> Any:
    """What a program gave, checked as if it had come over the network; raises UsageError."""
    text = written(value)
    try:
        return msgspec.json.decode(text, type=kind)
    except msgspec.DecodeError as error:
        raise UsageError(f"that is no {what}: {error}") from None


def _accepted(reply: ThingReply) -> int:
    if not reply.accepted:
        raise UsageError(f"refused: {reply.text}")
    return reply.number


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
