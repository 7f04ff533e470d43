"""Options shared by several commands, and the refusal of options that do not apply."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from deploy.run.options import Mode
from protocol.errors import UsageError


def _names(typed: str) -> list[tuple[str, str]]:
    from deploy.library.load import catalogue

    found = [(entry.name.removesuffix("N"), entry.text) for entry in catalogue()]
    found += [(path.as_posix(), "scenario file") for path in sorted(Path().glob(f"{typed}*.toml"))]
    return [(name, text) for name, text in found if name.startswith(typed)]


Scenario = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="A scenario file (TOML), or a library name such as figure-1.",
        autocompletion=_names,
    ),
]
RecordingFile = Annotated[
    Path, typer.Argument(metavar="RECORDING", help="A file that `disknav run --record` wrote.")
]
Seed = Annotated[
    int | None, typer.Option("--seed", metavar="N", min=0, help="Seed; overrides the scenario's.")
]
SettingOptions = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="PATH=VALUE", help="Override a key of the scenario: path.to.key=VALUE; repeatable."
    ),
]
JsonFile = Annotated[
    Path | None, typer.Option("--json", metavar="FILE", help="Write the result as JSON; '-' prints it alone.")
]
Web = Annotated[bool, typer.Option("--web", help="Serve a live page; its address is printed.")]
Record = Annotated[Path | None, typer.Option("--record", metavar="FILE", help="Record the run (MCAP).")]
Rotate = Annotated[
    list[str] | None,
    typer.Option(
        "--rotate",
        metavar="LIMIT",
        help="Start a new recording file at this size or age: 500MB, 1h; repeatable.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print neither progress nor table.")]
RunName = Annotated[
    str | None,
    typer.Option("--run", metavar="NAME", help="Name of the fleet's run; with --secure that of the keys."),
]
Run = Annotated[str, typer.Argument(metavar="RUN", help="Name of the run.")]
FreshRun = Annotated[
    str | None, typer.Option("--run", metavar="NAME", help="Name of the run; by default a fresh one.")
]
Router = Annotated[
    str | None,
    typer.Option(
        "--router",
        metavar="ENDPOINT",
        help="Endpoint at which the fleet's router listens; default tcp/127.0.0.1:7447 (tls/ with --secure).",
    ),
]
RouterThere = Annotated[
    str | None,
    typer.Option(
        "--router",
        metavar="ENDPOINT",
        help="Use the router that listens at this endpoint instead of starting one.",
    ),
]
Secure = Annotated[
    Path | None,
    typer.Option("--secure", metavar="DIR", help="Certificates and access rules of `disknav setup keys`."),
]
LogFile = Annotated[
    Path | None,
    typer.Option("--log", metavar="DIR", help="Write one log file per process to this directory."),
]
ModeOption = Annotated[
    Mode, typer.Option("--mode", help="Ticks wait for all robots, or follow the wall clock.")
]


def robots(least: int) -> Any:
    """`--robots` or `-n`: the number of robots."""
    return typer.Option("--robots", "-n", min=least, max=1000, help="Number of robots.")


def out(help_: str, metavar: str = "FILE") -> Any:
    """`--out` or `-o`: the file or folder that the command writes."""
    return typer.Option("--out", "-o", metavar=metavar, help=help_)


def refuse(options: Mapping[str, object], reason: str) -> None:
    """Refuse options that were given but do not apply.

    Args:
        options: their values, by name; None or False if not given.
        reason: why they do not apply, and what to do.

    Raises:
        UsageError: one was given.
    """
    given = [name for name, value in options.items() if value is not None and value is not False]
    if given:
        raise UsageError(f"{', '.join(given)} cannot apply: {reason}")


def refuse_bases(secure: Path | None) -> None:
    """Refuse keys for a run with ROS 2 bases; raises UsageError."""
    reason = "the access rules of a secured router admit no messages of ROS 2"
    refuse({"--secure": secure}, f"{reason}; use a router without keys, on a network of the fleet's own")
