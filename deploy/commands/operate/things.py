"""`disknav place`, `disknav take` and `disknav things`: what stands in the workspace of a running fleet."""

from __future__ import annotations

from typing import Annotated

import msgspec
import typer

from deploy.commands import options
from deploy.commands.operate.operating import Run, end_if_refused, operating, pairs
from deploy.output import json_output
from protocol.errors import UsageError
from protocol.messages import Thing
from protocol.requests.things import ThingOrder


def place(
    run: Run,
    points: Annotated[
        list[float],
        typer.Argument(metavar="X Y ...", help="Centre of a disk, or corners of a convex polygon, m."),
    ],
    radius: Annotated[float | None, typer.Option(help="Of a disk, m.")] = None,
    within: Annotated[float, typer.Option(min=0.0, help="Seconds to wait until it stands.")] = 30.0,
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Have a thing stand in the workspace of a running fleet: robots clear its place first.

    Examples: disknav place yard 0.1 0.05 --radius 0.02;
    disknav place yard -0.1 0.0 0.1 0.0 0.1 0.01 -0.1 0.01

    Exit status: 0 it stands, 1 refused, 2 invalid, 3 nobody answers, or somebody stays in its place.
    """
    thing = _thing(points, radius)
    with operating(run, router, secure) as operator:
        reply = operator.place(thing)
        end_if_refused(reply)
        if reply.text:
            print(f"beware: it {reply.text}")
        operator.stands(reply.number, within)
    print(f"thing {reply.number} stands")


def take(
    run: Run,
    number: Annotated[int, typer.Argument(help="Of the thing; [b]disknav things[/b] lists them.")],
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """Say that a thing is not there any more: robots drive where it was.

    Example: disknav take yard 1

    Exit status: 0 done, 1 refused, 2 invalid, 3 nobody answers.
    """
    with operating(run, router, secure) as operator:
        end_if_refused(operator.take(number))
    print(f"thing {number} is gone")


def things(
    run: Run,
    json_file: options.Json = None,
    router: options.Router = None,
    secure: options.Secure = None,
) -> None:
    """List what stands in the workspace of a running fleet and is no robot.

    Example: disknav things yard

    Exit status: 0 listed, 2 invalid, 3 nobody answers.
    """
    json_output.check(json_file)
    with operating(run, router, secure) as operator:
        there = operator.things().things
    json_output.write_json([msgspec.structs.asdict(thing) for thing in there], json_file)
    if not json_output.is_standard_output(json_file):
        print("\n".join(map(_line, there)) or "nothing stands there")


def _thing(numbers: list[float], radius: float | None) -> ThingOrder:
    """The thing that a command line stands for."""
    points = pairs(numbers)
    if radius is None:
        thing = ThingOrder(points=points)
    elif len(points) == 1:
        thing = ThingOrder(center=points[0], radius=radius)
    else:
        raise UsageError("--radius is for a disk, with one point; a polygon has corners only")
    if problem := thing.defect():
        raise UsageError(f"that is no thing: it {problem}")
    return thing


def _line(thing: Thing) -> str:
    where = " ".join(f"({x:g}, {y:g})" for x, y in thing.points)
    what = f"disk of {thing.radius:g} m at {where}" if len(thing.points) == 1 else f"polygon {where}"
    return f"{thing.number}: {what}{'' if thing.status == 'standing' else ', ' + thing.status}"
