"""`disknav fleet` and `disknav stop`: operations on a running fleet, named by the first argument."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import typer
from typer.core import TyperCommand

from deploy.cli import options
from deploy.output import EXIT_OTHERWISE, check_text, is_standard_output, write_json
from deploy.security.membership import KeyRing
from protocol.errors import MessageError, UsageError
from protocol.messages import GoalStatus, PlacedObstacle, Vector
from protocol.operations import Reply, read_operation
from protocol.scenario.model import Operation

if TYPE_CHECKING:
    from deploy.run.operator import Operator

app = typer.Typer(name="fleet", help="Give orders to a running fleet.", no_args_is_help=True)
_PATIENCE = 1e6  # s to wait for an order to end
_STANDING = 10.0  # s to wait for all robots to stand


class _NumbersCommand(TyperCommand):
    """Takes negative numbers as arguments, not as options."""

    ignore_unknown_options = True

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        known = {"--", *(name for each in self.get_params(ctx) for name in each.opts)}
        for word in args:
            if word.startswith("--") and word.partition("=")[0] not in known:
                ctx.fail(f"No such option: {word}")
        return super().parse_args(ctx, args)


@app.command(cls=_NumbersCommand)
def goal(
    run: options.Run,
    robot: Annotated[int, typer.Argument(metavar="ROBOT", help="Id of the robot.")],
    points: Annotated[
        list[float] | None,
        typer.Argument(
            metavar="X Y ...", help="Goals in m, one after another; none prints the robot's status."
        ),
    ] = None,
    queue: Annotated[
        bool, typer.Option("--queue", help="Append to the robot's goals instead of replacing them.")
    ] = False,
    patrol: Annotated[bool, typer.Option("--patrol", help="Repeat the points without end.")] = False,
    within: Annotated[float | None, typer.Option(help="Give up after this many simulated seconds.")] = None,
    cancel: Annotated[bool, typer.Option("--cancel", help="Cancel the goals; the robot stays.")] = False,
    wait: Annotated[bool, typer.Option("--wait", help="Return when the order has ended.")] = False,
    json_file: options.JsonFile = None,
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Give a robot goals, cancel them, or print its status.

    Example: disknav fleet goal yard 3 0.1 -0.05 0.1 0.15 --queue --wait

    Exit status: 0 accepted (with --wait: arrived), 1 refused, cancelled or given up, 2 invalid, 3 no answer;
    with --wait also: the robot is gone, another order followed, or the run ended.
    """
    check_text(json_file)
    if not points:
        options.refuse({"--wait": wait}, "there is no order to wait for: give points")
    if patrol and wait:
        raise UsageError("--wait: a patrol has no end; leave out --patrol or --wait")
    order = _order(robot, points or [], queue, patrol, within, cancel)
    with _operating(run, router, secure) as operator:
        reply = operator.operate(order)
        status = reply.goal(robot)
        if order is None and status is None:
            reply = msgspec.structs.replace(reply, accepted=False, text=f"no robot {robot}")
        if reply.halted:
            typer.echo("warning: an emergency stop is in force; disknav fleet release ends it", err=True)
        if wait and reply.accepted:
            status = operator.outcome(robot, reply.number, _PATIENCE)
    content = {
        "accepted": reply.accepted,
        "number": reply.number,
        "text": reply.text,
        "status": None if status is None else msgspec.structs.asdict(status),
    }
    write_json(content, json_file)
    if not is_standard_output(json_file):
        _print_goal(reply, status)
    arrived = status is not None and status.status == "arrived"
    if not reply.accepted or (wait and not arrived):
        raise typer.Exit(EXIT_OTHERWISE)


@app.command(cls=_NumbersCommand)
def add(
    run: options.Run,
    robot: Annotated[int, typer.Argument(metavar="ROBOT", help="Unused id for the new robot.")],
    x: Annotated[float, typer.Argument(metavar="X", help="Position of its disk: x, m.")],
    y: Annotated[float, typer.Argument(metavar="Y", help="Position of its disk: y, m.")],
    radius: Annotated[float, typer.Option(help="Radius of its disk, m.")],
    goal: Annotated[
        tuple[float, float] | None, typer.Option(help="Its goal, m; by default its position.")
    ] = None,
    within: Annotated[float, typer.Option(min=0.0, help="Seconds to wait for the disk to appear.")] = 30.0,
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Add a robot: its disk appears once the others keep clear of its position.

    [b]disknav run[/b] also starts its process, with [b]--hosts[/b] on the host that the table names for it;
    otherwise start it with [b]disknav node robot[/b]. With keys it needs one of its own: [b]disknav setup
    keys[/b] makes keys for the robots of the scenario and of its orders.

    Example: disknav fleet add yard 7 0.1 -0.2 --radius 0.03 --goal -0.1 0.2

    Exit status: 0 it has appeared, 1 refused, 2 invalid, 3 no answer, or a robot does not make room.
    """
    spec = {"id": robot, "radius": radius, "start": [x, y], "goal": list(goal or (x, y))}
    operation = _operation({"add": spec})
    with _operating(run, router, secure) as operator:
        _done(operator, operation)
        status = operator.appeared(robot, within)
    state = "is live" if status == "live" else "has appeared; its process has not joined yet"
    print(f"run {run}: robot {robot} {state}")


@app.command(cls=_NumbersCommand)
def remove(
    run: options.Run,
    robot: Annotated[int, typer.Argument(metavar="ROBOT", help="Id of the robot.")],
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Remove a robot: with the open tick its process ends, and its disk disappears.

    Example: disknav fleet remove yard 7

    Exit status: 0 it leaves, 1 refused, 2 invalid, 3 no answer.
    """
    operation = _operation({"remove": robot})
    with _operating(run, router, secure) as operator:
        _done(operator, operation)
    print(f"run {run}: robot {robot} leaves at the end of this tick")


@app.command(cls=_NumbersCommand)
def place(
    run: options.Run,
    points: Annotated[
        list[float],
        typer.Argument(metavar="X Y ...", help="Centre of a disk, or corners of a convex polygon, m."),
    ],
    radius: Annotated[float | None, typer.Option(help="Radius of a disk, m.")] = None,
    within: Annotated[
        float, typer.Option(min=0.0, help="Seconds to wait for the obstacle to appear.")
    ] = 30.0,
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Place an obstacle, once the robots keep clear of its position.

    Examples: disknav fleet place yard 0.1 0.05 --radius 0.02; disknav fleet place yard -0.1 0.0 0.1 0.0 0.1
    0.01 -0.1 0.01

    Exit status: 0 it is in place, 1 refused, 2 invalid, 3 no answer, or a robot does not make room.
    """
    operation = _operation({"place": _obstacle(points, radius)})
    if operation.place is not None and (defect := operation.place.defect()):
        raise UsageError(f"invalid obstacle: it {defect}")
    with _operating(run, router, secure) as operator:
        reply = _done(operator, operation)
        if reply.text:
            typer.echo(f"warning: the obstacle {reply.text}", err=True)
        operator.stands(reply.number, within)
    print(f"obstacle {reply.number} is in place")


@app.command(cls=_NumbersCommand)
def take(
    run: options.Run,
    number: Annotated[
        int,
        typer.Argument(
            metavar="NUMBER", help="Number of the obstacle; [b]disknav fleet things[/b] lists them."
        ),
    ],
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Tell the fleet that an obstacle was taken away.

    Example: disknav fleet take yard 1

    Exit status: 0 done, 1 refused, 2 invalid, 3 no answer.
    """
    operation = _operation({"take": number})
    with _operating(run, router, secure) as operator:
        _done(operator, operation)
    print(f"obstacle {number} is gone")


@app.command("things")
def obstacles(
    run: options.Run,
    json_file: options.JsonFile = None,
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """List the obstacles in the workspace.

    Example: disknav fleet things yard

    Exit status: 0 listed, 2 invalid, 3 no answer.
    """
    check_text(json_file)
    with _operating(run, router, secure) as operator:
        there = operator.operate().obstacles
    write_json([msgspec.structs.asdict(obstacle) for obstacle in there], json_file)
    if not is_standard_output(json_file):
        print("\n".join(map(_line, there)) or "there are no obstacles")


def stop(run: options.Run, router: options.Router = None, secure: options.Secure = None) -> None:
    """Emergency stop: every robot brakes at once and stands until [b]disknav fleet release[/b].

    Simulated robots brake in the present tick, external bases in the next. Repeated until all stand.

    Example: disknav stop yard

    Exit status: 0 all stand, 1 some do not after 10 s, 2 invalid, 3 no answer.
    """
    with _operating(run, router, secure) as operator:
        reply = operator.stop(_STANDING)
    if reply.moving or not reply.halted:
        names = ", ".join(map(str, reply.moving)) or "unknown"
        print(f"run {run}: asked to stop, but these robots do not stand after {_STANDING:g} s: {names}")
        raise typer.Exit(EXIT_OTHERWISE)
    print(f"run {run}: all robots stand")


@app.command()
def release(run: options.Run, router: options.Router = None, secure: options.Secure = None) -> None:
    """Let the robots of a stopped fleet move again.

    Example: disknav fleet release yard

    Exit status: 0 released, 1 refused, 2 invalid, 3 no answer.
    """
    with _operating(run, router, secure) as operator:
        reply = operator.operate()
        if reply.halted:
            reply = _done(operator, Operation(halt=False))
            print(f"run {run}: released from tick {reply.tick} on")
        else:
            print(f"run {run}: no stop is in force")


@app.command()
def probe(
    run: options.Run,
    role: Annotated[str, typer.Argument(metavar="ROLE", help="world, or a robot such as robot-3.")],
    within: Annotated[float, typer.Option(min=0.1, help="Seconds to listen.")] = 5.0,
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Check that a process is alive: returns when a message from it arrives.

    Example: disknav fleet probe yard robot-3

    Exit status: 0 it is alive, 2 invalid, 3 no message in time.
    """
    from deploy.run.operator import probe as listen

    membership = KeyRing(secure)
    listen(membership.client(role, (router,), timeout=within), membership.named_run(run), role, within)


def _operating(run: str, router: str | None, secure: Path | None) -> AbstractContextManager[Operator]:
    from deploy.run.operator import operating

    return operating(run, router, secure)


def _operation(asked: dict[str, Any]) -> Operation:
    """Operation of a command line; raises UsageError."""
    try:
        return read_operation(asked)
    except MessageError as error:
        raise UsageError(str(error)) from None


def _done(operator: Operator, operation: Operation) -> Reply:
    reply = operator.operate(operation)
    if not reply.accepted:
        typer.echo(f"refused: {reply.text}", err=True)
        raise typer.Exit(EXIT_OTHERWISE)
    return reply


def _pairs(numbers: Sequence[float]) -> list[list[float]]:
    if len(numbers) % 2:
        raise UsageError("points are pairs of x and y: a number is missing, or there is one too many")
    return [list(pair) for pair in zip(numbers[::2], numbers[1::2], strict=True)]


def _order(
    robot: int, points: list[float], queue: bool, patrol: bool, within: float | None, cancel: bool
) -> Operation | None:
    """Order of a command line; None if it only asks for the status."""
    places = _pairs(points)
    if cancel and (points or queue or patrol or within is not None):
        raise UsageError("--cancel goes alone: leave out the points and other options")
    if not points and (queue or patrol or within is not None):
        raise UsageError("--queue, --patrol and --within need points: disknav fleet goal RUN ROBOT X Y")
    if not points and not cancel:
        return None
    goal = {"robot": robot, "points": places, "queue": queue, "patrol": patrol, "within": within}
    return _operation({"goal": goal})


def _print_goal(reply: Reply, status: GoalStatus | None) -> None:
    if not reply.accepted:
        typer.echo(f"refused: {reply.text}", err=True)
        return
    if reply.text:
        typer.echo(f"warning: the goal {reply.text}", err=True)
    if status is not None:
        ahead = f", {status.ahead} more after it" if status.ahead else ""
        print(f"robot {status.robot}: {status.status}, {_point(status.goal)}{ahead}")


def _obstacle(numbers: list[float], radius: float | None) -> dict[str, Any]:
    points = _pairs(numbers)
    if radius is None and len(points) == 1:
        raise UsageError("one point is a disk: add --radius, or the other corners of a polygon")
    if radius is None:
        return {"points": points}
    if len(points) != 1:
        raise UsageError("--radius is for a disk, with one point; a polygon has corners only")
    return {"center": points[0], "radius": radius}


def _line(obstacle: PlacedObstacle) -> str:
    where = " ".join(map(_point, obstacle.points))
    what = f"disk of {obstacle.radius:g} m at {where}" if len(obstacle.points) == 1 else f"polygon {where}"
    return f"{obstacle.number}: {what}{'' if obstacle.status == 'standing' else ', ' + obstacle.status}"


def _point(point: Vector) -> str:
    return f"({point[0]:g}, {point[1]:g})"
