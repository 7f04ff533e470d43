"""Every subcommand of `disknav`."""

from __future__ import annotations

import typer

from deploy.commands import scenario
from deploy.commands.certify import certify
from deploy.commands.check import check
from deploy.commands.endure import endure, flood
from deploy.commands.info import info
from deploy.commands.monitor import monitor
from deploy.commands.operate import keys
from deploy.commands.operate.deploy import deploy
from deploy.commands.operate.goal import goal
from deploy.commands.operate.host import host
from deploy.commands.operate.probe import probe
from deploy.commands.operate.single import robot, router, world
from deploy.commands.plot import plot
from deploy.commands.replay import replay
from deploy.commands.run import run
from deploy.commands.serve import serve
from deploy.commands.study import study

app = typer.Typer(
    name="disknav",
    help="A fleet of disk robots, one process each, that reach their goals without touching.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode="rich",
)

for command in (
    run,
    serve,
    check,
    certify,
    study,
    plot,
    replay,
    info,
    monitor,
    robot,
    world,
    router,
    probe,
    deploy,
    endure,
    flood,
):
    app.command()(command)
app.command(context_settings={"ignore_unknown_options": True})(goal)  # -0.1 is no option
app.command(hidden=True)(host)
app.add_typer(scenario.app, name="scenario")
app.add_typer(keys.app, name="keys")
