"""`disknav stop` and `disknav release`: the emergency stop of a running fleet."""

from __future__ import annotations

from pathlib import Path

from deploy.commands import options
from deploy.commands.operate.operating import Run, operating


def stop(run: Run, router: options.Router = None, secure: options.Secure = None) -> None:
    """Emergency stop: every robot brakes at once, and stands until [b]disknav release[/b].

    It brakes in the present tick, outside the simulation in the next.

    Example: disknav stop yard

    Exit status: 0 it is in force, 2 invalid, 3 nobody answers.
    """
    _say(run, router, secure, halt=True)


def release(run: Run, router: options.Router = None, secure: options.Secure = None) -> None:
    """Let the robots of a stopped fleet move again.

    Example: disknav release yard

    Exit status: 0 they are released, 2 invalid, 3 nobody answers.
    """
    _say(run, router, secure, halt=False)


def _say(run: str, router: str | None, secure: Path | None, *, halt: bool) -> None:
    with operating(run, router, secure) as operator:
        told = operator.halt(halt)
    print(f"run {run}: {'everybody stands' if told.halted else 'released'} from tick {told.tick} on")
