"""Every subcommand of `disknav`, by what people want to do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import typer
from typer.core import TyperGroup

from deploy.commands import scenario
from deploy.commands.certify import certify
from deploy.commands.check import check
from deploy.commands.doctor import doctor
from deploy.commands.look.info import info
from deploy.commands.look.monitor import monitor
from deploy.commands.look.plot import plot
from deploy.commands.look.replay import replay
from deploy.commands.operate import hosts, keys
from deploy.commands.operate.calibrate import calibrate
from deploy.commands.operate.deploy import deploy
from deploy.commands.operate.goal import goal
from deploy.commands.operate.host import host
from deploy.commands.operate.membership import add, remove
from deploy.commands.operate.probe import probe
from deploy.commands.operate.single import robot, router, world
from deploy.commands.operate.stop import release, stop
from deploy.commands.operate.things import place, take, things
from deploy.commands.run import run
from deploy.commands.serve import serve
from deploy.commands.study import study


class Commands(TyperGroup):
    """All subcommands; `--json` with no file after it means standard output, in each of them."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """See click."""
        spelled: list[str] = []
        for word, following in zip(args, [*args[1:], "--"], strict=False):
            spelled.append(word)
            if word == "--json" and following.startswith("-") and following != "-":
                spelled.append("-")
        return super().parse_args(ctx, spelled)


app = typer.Typer(
    name="disknav",
    help="A fleet of disk robots, one process each, that reach their goals without touching.",
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode="rich",
)

GROUPS: dict[str, tuple[Callable[..., None] | typer.Typer, ...]] = {
    "Run": (run, serve, goal, scenario.app, check),
    "Look": (info, plot, replay, monitor),
    "Study": (study, certify),
    "Operate": (
        *(add, remove, place, take, things, stop, release),
        *(router, world, robot, calibrate, keys.app, hosts.app, deploy, probe, doctor),
    ),
}
for _group, _commands in GROUPS.items():
    for _command in _commands:
        if isinstance(_command, typer.Typer):
            app.add_typer(_command, rich_help_panel=_group)
        else:
            takes_points = _command in (goal, add, place)  # -0.1 is no option
            lenient = {"ignore_unknown_options": True} if takes_points else {}
            app.command(rich_help_panel=_group, context_settings=lenient)(_command)
app.command(hidden=True)(host)
