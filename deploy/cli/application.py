"""All subcommands of `disknav`, grouped by task."""

from __future__ import annotations

import re
from collections.abc import Callable
from inspect import getdoc
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from deploy.cli import fleet, node, recording, scenario, setup
from deploy.cli.learn import certify, check, study
from deploy.cli.monitor import monitor
from deploy.cli.run import run


class CommandGroup(TyperGroup):
    """All subcommands. In each, `--json` without a file means standard output, and no flag has a type."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        for each in (each for command in (self, *self.commands.values()) for each in command.get_params(ctx)):
            if getattr(each, "is_flag", False):
                each.metavar = ""  # <bool> would ask for a value
        spelled: list[str] = []
        for word, following in zip(args, [*args[1:], "--"], strict=False):
            if not following:  # mostly an unset variable
                ctx.fail(f"The word after {word!r} is empty: give a value, or leave it out.")
            spelled.append(word)
            if word == "--json" and following.startswith("-") and following != "-":
                spelled.append("-")
        return super().parse_args(ctx, spelled)

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except typer.BadParameter as error:
            error.message = error.message.removeprefix("Value error, ")
            raise


app = typer.Typer(
    name="disknav",
    cls=CommandGroup,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode="rich",
)


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"disknav {version('disknav')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and end.")
    ] = False,
) -> None:
    """Collision-free navigation for fleets of disk-shaped robots, one process each.

    Example: disknav run figure-1 --plot figure-1.png
    """
    del version  # its callback has ended the command


def _paragraphs(command: Callable[..., None] | None) -> str:
    """The help of a command, with a line for each paragraph, which the terminal wraps."""
    return "\n\n".join(" ".join(each.split()) for each in (getdoc(command) or "").split("\n\n"))


GROUPS: dict[str, tuple[Callable[..., None] | typer.Typer, ...]] = {
    "Run": (run, monitor, fleet.app, fleet.stop, recording.app),
    "Learn": (check, certify, study),
    "Prepare": (scenario.app, setup.app, node.app),
}
_EXAMPLE = re.compile("^Examples?:.*", re.MULTILINE)
for _group, _commands in GROUPS.items():
    for _command in _commands:
        if isinstance(_command, typer.Typer):
            for _info in _command.registered_commands:
                _info.help = _paragraphs(_info.callback)
            _example = _EXAMPLE.findall(_command.registered_commands[0].help or "")[0]
            _text = f"{_command.info.help}\n\n{_example}"
            app.add_typer(_command, cls=CommandGroup, rich_help_panel=_group, help=_text)
        else:
            app.command(rich_help_panel=_group, help=_paragraphs(_command))(_command)
