"""Every command that README and the documentation show is run, or at least understood by the command line.

A fenced block marked `sh` holds commands. The lines of a page that begin with `disknav` run one after
another in a folder of the page's own (of an example, a copy of its folder), and have to succeed; proofs,
checks of the library and moving pictures in campaigns only. A comment before a block changes that:

    <!-- not run: why -->     its commands and options have to exist, no more
    <!-- file: mine.toml -->  the block, of whatever kind, is the content of this file in the page's folder
"""

import re
import shlex
import shutil
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import typer

from deploy.cli.application import app
from tests.forks import Forks

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
COMMAND: Any = typer.main.get_command(app)
_BLOCK = re.compile(
    r"(?:<!-- (not run|file): ([^>]*?) -->\n+)?^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE
)


class Shown(NamedTuple):
    """A block: its words for the command line, or the file that it is."""

    commands: list[list[str]]
    runs: bool
    file: str
    text: str


def blocks(page: Path) -> list[Shown]:
    found = []
    for mark, said, kind, text in _BLOCK.findall(page.read_text()):
        lines = [shlex.split(line, comments=True) for line in text.splitlines()] if kind == "sh" else []
        commands = [words[1:] for words in lines if words and words[0] == "disknav"]
        if commands or mark == "file":
            found.append(Shown(commands, mark != "not run", said if mark == "file" else "", text))
    return found


def redirected(words: list[str]) -> tuple[list[str], str]:
    return (words[:-2], words[-1]) if words[-2:-1] == [">"] else (words, "output")


def _name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


WITH_EXCHANGE = [page for page in PAGES if any(block.commands for block in blocks(page))]
_RUN = {
    page: {tuple(words) for block in blocks(page) if block.runs for words in block.commands}
    for page in WITH_EXCHANGE
}
OWN = [page for page in WITH_EXCHANGE if not any(_RUN[page] < each for each in _RUN.values())]
"""Without those that show nothing but what another page does."""


def carry_out(page: Path, disknav: Forks, folder: Path, *, everything: bool) -> None:
    """Run the commands of a page; unless `everything`, none that takes long."""
    if page.parent.parent.name == "examples":
        shutil.copytree(page.parent, folder, dirs_exist_ok=True)
    for block in blocks(page):
        if block.file:
            (folder / block.file).write_text(block.text)
        for words in block.commands if block.runs else ():
            if everything or not takes_long(words):
                call, target = redirected(words)
                done = disknav(*call, cwd=folder)
                assert done.returncode == 0, (words, done.stderr)
                (folder / target).write_text(done.stdout)


def takes_long(words: list[str]) -> bool:
    """Whether a command proves something, checks a scenario of the library, or draws a moving picture.

    The tests of all three do so in small.
    """
    tries = words[0] == "check" and not words[1].endswith(".toml")
    return words[0] == "certify" or tries or any(word.endswith(".webp") for word in words)


@pytest.mark.process
@pytest.mark.timeout(390)
@pytest.mark.parametrize("page", OWN, ids=_name)
def test_they_run(page: Path, disknav: Forks, tmp_path: Path) -> None:
    carry_out(page, disknav, tmp_path, everything=False)


@pytest.mark.campaign
@pytest.mark.timeout(900)
@pytest.mark.parametrize("page", WITH_EXCHANGE, ids=_name)
def test_so_does_what_takes_long(page: Path, disknav: Forks, tmp_path: Path) -> None:
    if any(takes_long(words) for block in blocks(page) for words in block.commands if block.runs):
        carry_out(page, disknav, tmp_path, everything=True)


@pytest.mark.parametrize("page", WITH_EXCHANGE, ids=_name)
def test_their_options_exist(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for block in blocks(page):
        for words in block.commands:
            command, rest = COMMAND, [word for word in words if word != "--help"]
            while hasattr(command, "commands") and rest:
                command = command.commands[rest.pop(0)]
            rest, _ = redirected(rest)
            for word in rest:  # files of the reader's own
                if Path(word).suffix and not word.startswith("-") and Path(word).parent == Path():
                    Path(word).touch()
            if rest:
                command.make_context("disknav", rest)


def test_there_are_commands() -> None:
    assert sum(len(block.commands) for page in PAGES for block in blocks(page) if block.runs) >= 20
