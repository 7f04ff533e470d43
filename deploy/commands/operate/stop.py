"""`disknav stop` and `disknav release`: the emergency stop of a running fleet."""

from __future__ import annotations

import typer

from deploy.commands import options
from deploy.commands.operate.operating import Run, operating
from deploy.output.exit_status import EXIT_OTHERWISE

_WITHIN = 10.0  # s


def stop(run: Run, router: options.Router = None, secure: options.Secure = None) -> None:
    """Emergency stop: every robot brakes at once, and stands until [b]disknav release[/b].

    It brakes in the present tick, outside the simulation in the next. The stop is repeated until all stand.

    Example: disknav stop yard

    Exit status: 0 all stand, 1 some do not after 10 s, 2 invalid, 3 nobody answers.
    """
    with operating(run, router, secure) as operator:
        told = operator.stop(_WITHIN)
    if told.moving or not told.halted:
        names = ", ".join(map(str, told.moving)) or "unknown"
        print(f"run {run}: asked to stop, but these robots do not stand after {_WITHIN:g} s: {names}")
        raise typer.Exit(EXIT_OTHERWISE)
    print(f"run {run}: everybody stands from tick {told.tick} on")


def release(run: Run, router: options.Router = None, secure: options.Secure = None) -> None:
    """Let the robots of a stopped fleet move again.

    Example: disknav release yard

    Exit status: 0 they are released, 1 they have to stand, 2 invalid, 3 nobody answers.
    """
    with operating(run, router, secure) as operator:
        told = operator.halt(False)
    if told.halted:
        print(f"run {run}: not released: {told.text}")
        raise typer.Exit(EXIT_OTHERWISE)
    print(f"run {run}: released from tick {told.tick} on")
