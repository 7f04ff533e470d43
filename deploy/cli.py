"""The `disknav` command: every subcommand, and how errors become words and exit statuses."""

from __future__ import annotations

import signal
import sys

import typer

from deploy import compiled
from deploy.commands import keys, scenario
from deploy.commands.check import check
from deploy.commands.deploy import deploy
from deploy.commands.endure import endure, flood
from deploy.commands.host import host
from deploy.commands.info import info
from deploy.commands.monitor import monitor
from deploy.commands.plot import plot
from deploy.commands.probe import probe
from deploy.commands.replay import replay
from deploy.commands.run import run
from deploy.commands.single import robot, router, world
from deploy.commands.study import study
from deploy.result import EXIT_FAULT, EXIT_INTERRUPTED, EXIT_INVALID
from protocol.errors import CertificateError, DisknavError, DocumentError, KeyGrammarError, UsageError

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
    check,
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
app.command(hidden=True)(host)
app.add_typer(scenario.app, name="scenario")
app.add_typer(keys.app, name="keys")

_INVALID = (DocumentError, UsageError, KeyGrammarError, CertificateError)


def main() -> None:
    """Entry point of the `disknav` command. SIGTERM ends it as Ctrl-C does."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        compiled.check()
        app()
    except _INVALID as error:
        _fail(error, EXIT_INVALID)
    except DisknavError as error:
        _fail(error, EXIT_FAULT)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)


def _fail(error: DisknavError, status: int) -> None:
    print(f"disknav: {error}", file=sys.stderr)
    sys.exit(status)


if __name__ == "__main__":
    main()
