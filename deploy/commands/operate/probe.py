"""`disknav probe`: for the health checks of whatever orchestrator runs a fleet."""

from __future__ import annotations

from typing import Annotated

import typer

from deploy.commands import options
from deploy.security.membership import Membership


def probe(
    role: Annotated[str, typer.Argument(help="world, or a robot such as robot-3.")],
    run: options.RunName = None,
    router: options.Router = None,
    within: Annotated[float, typer.Option(min=0.1, help="How long to listen, s.")] = 5.0,
    secure: options.Secure = None,
) -> None:
    """Find out whether a process of a run is well: ends as soon as a message from it arrives.

    Example: disknav probe robot-3 --run demo

    Exit status: 0 it is well, 2 invalid, 3 no message in time.
    """
    from deploy.processes.probe import probe as listen

    membership = Membership(secure)
    name, endpoint = membership.named_run(run), router or membership.default_router
    listen(membership.client(role, (endpoint,), timeout=within), name, role, within)
