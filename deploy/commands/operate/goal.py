"""`disknav goal`: send a robot of a running fleet elsewhere."""

from __future__ import annotations

from typing import Annotated

import msgspec
import typer

from deploy.commands import options
from deploy.commands.operate.operating import Run, operating, pairs
from deploy.output import json_output
from deploy.output.exit_status import EXIT_OTHERWISE
from protocol.errors import UsageError
from protocol.messages import GoalStatus
from protocol.requests.goals import GoalOrder, GoalReply

_PATIENCE = 1e6  # s to wait for an end without --within


def goal(
    run: Run,
    robot: Annotated[int, typer.Argument(help="Id of the robot.")],
    points: Annotated[
        list[float] | None,
        typer.Argument(metavar="X Y ...", help="Where to go, m, point by point; none asks how things stand."),
    ] = None,
    queue: Annotated[bool, typer.Option("--queue", help="After what it is doing, not at once.")] = False,
    patrol: Annotated[bool, typer.Option("--patrol", help="Round and round through all points.")] = False,
    within: Annotated[
        float | None, typer.Option(help="Simulated seconds after which it gives up and stays where it is.")
    ] = None,
    cancel: Annotated[bool, typer.Option("--cancel", help="Stay where it is.")] = False,
    wait: Annotated[bool, typer.Option("--wait", help="Return only when an end has come of it.")] = False,
    json_file: options.Json = None,
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Send a robot of a running fleet elsewhere, cancel what it is doing, or ask how it stands.

    Example: disknav goal yard 3 0.1 -0.05 0.1 0.15 --queue --wait

    Exit status: 0 accepted (with --wait: arrived), 1 refused, cancelled or given up, 2 invalid, 3 nobody
    answers.
    """
    json_output.check(json_file)
    if not points:
        options.refuse({"--wait": wait}, "nothing is ordered that could end: give points")
    order = _order(points or [], queue, patrol, within, cancel)
    if patrol and wait:
        raise UsageError("--wait: a patrol has no end; leave out --patrol or --wait")
    with operating(run, router, secure) as operator:
        reply = operator.status(robot) if order is None else operator.order(robot, order)
        ended = reply.status
        if wait and order is not None and reply.accepted:
            ended = operator.outcome(robot, reply.number, _PATIENCE)
    content = {
        **msgspec.to_builtins(reply),
        "status": None if ended is None else msgspec.structs.asdict(ended),
    }
    json_output.write_json(content, json_file)
    if not json_output.is_standard_output(json_file):
        _say(reply, ended)
    failed = not reply.accepted or (wait and (ended is None or ended.status != "arrived"))
    if failed and not (cancel and reply.accepted):
        raise typer.Exit(EXIT_OTHERWISE)


def _order(
    points: list[float], queue: bool, patrol: bool, within: float | None, cancel: bool
) -> GoalOrder | None:
    """The order that the command line stands for; None for a question."""
    places = pairs(points)
    if cancel and (points or queue or patrol or within is not None):
        raise UsageError("--cancel goes alone: leave out the points and other options")
    if not points and (queue or patrol or within is not None):
        raise UsageError("--queue, --patrol and --within need points: disknav goal RUN ROBOT X Y")
    if not points and not cancel:
        return None
    try:
        return msgspec.convert(
            {"points": places, "queue": queue, "patrol": patrol, "within": within}, GoalOrder
        )
    except msgspec.ValidationError as error:
        raise UsageError(f"that is no order: {error}") from None


def _say(reply: GoalReply, status: GoalStatus | None) -> None:
    if not reply.accepted:
        print(f"refused: {reply.text}")
        return
    if reply.text:
        print(f"beware: {reply.text}")
    if status is not None:
        x, y = status.goal
        ahead = f", {status.ahead} more after it" if status.ahead else ""
        print(f"robot {status.robot}: {status.status}, ({x:g}, {y:g}){ahead}")
