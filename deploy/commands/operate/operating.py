"""What commands have in common that speak to the world of a running fleet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.output.exit_status import EXIT_OTHERWISE
from deploy.security.membership import Membership
from deploy.security.roster import OPERATOR
from protocol.errors import UsageError
from protocol.messages import Vector
from protocol.requests.fleet import FleetReply
from protocol.requests.things import ThingReply

if TYPE_CHECKING:
    from deploy.run.operator import Operator

Run = Annotated[str, typer.Argument(help="Name of the run.")]


@contextmanager
def operating(run: str, router: str | None, secure: Path | None) -> Iterator[Operator]:
    """Speak to the world of `run`, with the operator's key where there are keys."""
    from deploy.run import operator

    membership = Membership(secure)
    membership.run(run)  # the keys are of this run
    connection = membership.client(OPERATOR, (router or membership.default_router,))
    with operator.operating(connection, run) as session:
        yield session


def end_if_refused(reply: FleetReply | ThingReply) -> None:
    """End the command with status 1 if what it asked for was refused."""
    if not reply.accepted:
        print(f"refused: {reply.text}")
        raise typer.Exit(EXIT_OTHERWISE)


def pairs(numbers: Sequence[float]) -> tuple[Vector, ...]:
    """Points of a command line, m.

    Raises:
        UsageError: a number is missing.
    """
    if len(numbers) % 2:
        raise UsageError("points are pairs of x and y: one number is missing, or one is too many")
    return tuple(zip(numbers[::2], numbers[1::2], strict=True))
