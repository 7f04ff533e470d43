"""`disknav add` and `disknav remove`: who is in a running fleet."""

from __future__ import annotations

from typing import Annotated

import typer

from deploy.commands import options
from deploy.commands.operate.operating import Run, end_if_refused, operating
from protocol.scenario.model import RobotSpec


def add(
    run: Run,
    robot: Annotated[int, typer.Argument(help="Id of the new robot, which nobody has.")],
    x: Annotated[float, typer.Argument(help="Where its disk is to appear, m.")],
    y: Annotated[float, typer.Argument(help="Likewise.")],
    radius: Annotated[float, typer.Option(help="Of its disk, m.")],
    goal: Annotated[
        tuple[float, float] | None, typer.Option(help="Where it is to go, m; it stays unless given.")
    ] = None,
    within: Annotated[float, typer.Option(min=0.0, help="Seconds to wait until it has appeared.")] = 30.0,
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Add a robot to a running fleet: the others clear its place, then its disk is put there.

    Where [b]disknav serve[/b] or [b]disknav run[/b] started the fleet its process is started, too, on the
    host that a table names for it, if there is one; elsewhere start it with [b]disknav robot[/b]. With keys
    it needs its own: [b]disknav keys new[/b] makes them for robots of the scenario and of its orders.

    Example: disknav add yard 7 0.1 -0.2 --radius 0.03 --goal -0.1 0.2

    Exit status: 0 it has appeared, 1 refused, 2 invalid, 3 nobody answers, or somebody stays in its place.
    """
    spec = RobotSpec(robot, radius, (x, y), goal or (x, y))
    with operating(run, router, secure) as operator:
        end_if_refused(operator.add(spec))
        member = operator.appeared(robot, within)
    print(f"run {run}: robot {robot} {'takes part' if member.status == 'live' else 'stands in its place'}")


def remove(
    run: Run,
    robot: Annotated[int, typer.Argument(help="Id of the robot.")],
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Take a robot out of a running fleet: its process ends, its disk is taken away.

    Example: disknav remove yard 7

    Exit status: 0 it is gone, 1 refused, 2 invalid, 3 nobody answers.
    """
    with operating(run, router, secure) as operator:
        end_if_refused(operator.remove(robot))
    print(f"run {run}: robot {robot} is gone")
