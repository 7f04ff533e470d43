"""One command line: an option means the same in every command, or is refused where it cannot apply."""

import json
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from deploy.cli.application import app
from deploy.software import Finding
from protocol.errors import UsageError
from tests.scripts import ended

COMMAND = typer.main.get_command(app)


def commands(command: Any = COMMAND, name: str = "") -> Iterator[tuple[str, Any]]:
    if not hasattr(command, "commands"):
        yield name, command
        return
    for word, inner in command.commands.items():
        if not inner.hidden:
            yield from commands(inner, f"{name} {word}".strip())


ALL = dict(commands())


def option(name: str) -> dict[str, Any]:
    return {title: each for title, it in ALL.items() for each in it.params if name in each.opts}


@pytest.mark.parametrize("name", ["--json", "--seed", "--set", "--quiet", "--secure", "--mode"])
def test_an_option_means_the_same_everywhere(name: str) -> None:
    found = option(name)
    own_seed = {"study", "certify", "scenario new", "scenario import"}  # not over a scenario's
    texts = {each.help for title, each in found.items() if name != "--seed" or title not in own_seed}
    assert len(found) >= 3
    assert len(texts) == 1, texts


def test_a_short_option_means_the_same_everywhere() -> None:
    meanings: dict[str, set[str]] = {}
    for command in ALL.values():
        for parameter in command.params:
            for short in (name for name in parameter.opts if len(name) == 2):
                meanings.setdefault(short, set()).add(parameter.opts[0])
    assert {short: names for short, names in meanings.items() if len(names) > 1} == {}
    assert meanings["-n"] == {"--robots"}
    assert meanings["-o"] == {"--out"}


@pytest.mark.parametrize("title", ALL)
def test_every_command_has_an_example(title: str) -> None:
    group = COMMAND.commands[title.split(maxsplit=1)[0]]  # type: ignore[attr-defined]
    assert f"disknav {title}" in ALL[title].help
    assert "Example" in ALL[title].help
    assert f"disknav {group.name} " in group.help


REFUSED = [
    ("run figure-1 --transport local --router tcp/127.0.0.1:7447", "--router"),
    ("run figure-1 --mode realtime --speed 2", "--speed"),
    ("run figure-1 --transport local --restart on-failure", "--restart"),
    ("run figure-1 --open", "--open"),
    ("run figure-1 --keep --speed 2", "--speed"),
    ("run figure-1 --keep --router tcp/127.0.0.1:7447 --listen tcp/127.0.0.1:7448", "--listen"),
    ("run figure-1 --keep --transport mesh", "--keep"),
    ("run figure-1 --keep --plot a.png", "--plot"),
    ("run figure-1 --rotate 1h", "--rotate"),
    ("run figure-1 --record a.mcap --json a.mcap", "has the file already"),
    ("run a.toml --record a.toml", "has the file already"),
    ("run a.png --plot a.png", "has the file already"),
    ("recording plot a.png --out a.png", "has the file already"),
    ("recording replay a.mcap --ros2 a.mcap", "has the file already"),
    ("scenario import /dev/null --out /dev/null", "has the file already"),
    ("certify figure-1 --out figure-1", "has the file already"),
    ("study peers --law a.py:A --json a.py", "has the file already"),
    ("node world a.toml --run x --checkpoint a.toml", "has the file already"),
    ("fleet goal yard 3 --wait", "--wait"),
    ("node router --host left --print-config", "--host"),
    ("monitor x --port 8000", "--port"),
    ("study tuning --fresh --json -", "--fresh"),
    ("study scale --jobs 2", "--jobs"),
    ("certify --verify x.json --out here.json", "--out"),
    ("certify --verify x.json --set control.k=3", "--set"),
    ("setup deploy compose figure-1 -o fleet --router tls/10.0.0.1:7447", "--router"),
    ("setup deploy systemd figure-1 -o fleet --image mine", "--image"),
    ("setup deploy compose turtlebots-2 --set world.plant=external -o fleet", "external bases"),
    ("scenario new swap --density 0.2", "--density"),
    ("recording replay x.mcap --speed 3", "--speed"),
    ("recording replay x.mcap --run other", "--run"),
    ("recording replay x.mcap --zenoh --run a/b", "run name"),
    ("check a.toml --json a.toml", "has the file already"),
    ("setup calibrate figure-1 99", "has no robot 99; there are 1, 2"),
    ("setup calibrate figure-1 1", "has no base"),
    ("fleet goal yard 1 0.1 0.2 --within -1", "within"),
    ("fleet remove yard -1", "at least 1, is -1"),
    ("setup keys keys -s figure-1 --host a,b", "'a,b' is no host"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("line", "text"), REFUSED)
def test_what_is_refused(line: str, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match=text):
        CliRunner().invoke(app, line.split(), catch_exceptions=False)
    assert list(tmp_path.iterdir()) == []


def test_what_typer_says_names_what_is_expected() -> None:
    said = [CliRunner().invoke(app, f"run a {it}".split(" ")).output for it in ("-h", "--mode x", "--log ")]
    assert "<bool>" not in said[0]
    assert "'--mode': 'x' is not one of" in said[1]
    assert "after '--log' is empty" in said[2]


@pytest.mark.slow
@pytest.mark.parametrize("wish", ["--web --port {}", "--foxglove --port {}", "--metrics {}", "--metrics 7{}"])
def test_an_address_where_nothing_can_listen_is_refused_before_there_is_a_link(wish: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        words = wish.format(taken.getsockname()[1]).split()
        with pytest.raises(UsageError, match=f"{words[-2]}: cannot listen at {words[-1]}: .*free PORT"):
            CliRunner().invoke(app, ["monitor", "x", *words], catch_exceptions=False)


@pytest.mark.slow
@pytest.mark.parametrize("file", ["", "check.json"])
def test_json_without_a_file_is_standard_output(file: str, tmp_path: Path) -> None:
    """Else the table stays on the terminal."""
    words = ["check", "figure-2", "--seed", "3", "--json", *([str(tmp_path / file)] if file else [])]
    said = CliRunner().invoke(app, words, catch_exceptions=False).stdout
    assert json.loads((tmp_path / file).read_text() if file else said)["scenario"] == "figure-2"
    assert "figure-2" in said


@pytest.mark.slow
def test_the_shell_completes_names_of_the_library() -> None:
    asked = {"_DISKNAV_COMPLETE": "complete_bash", "COMP_WORDS": "disknav run fig", "COMP_CWORD": "2"}
    code = f"import os, sys; os.environ |= {asked}; sys.argv = ['disknav']"
    done = ended(f"{code}; from disknav.__main__ import main; main()", timeout=60.0)
    assert "figure-1" in done.stdout.split()


@pytest.mark.process
def test_doctor_finds_this_machine_fit() -> None:
    done = CliRunner().invoke(app, ["setup", "doctor", "--json"], catch_exceptions=False)
    found = {each["what"]: each for each in json.loads(done.stdout)}
    assert done.exit_code == 0
    assert found["fleet"]["level"] == "good"
    assert "Python 3." in found["installation"]["text"]
    assert all(
        each["remedy"]
        for each in found.values()
        if each["level"] != "good" and "unknown on this system" not in each["text"]
    )


def test_doctor_prints_commands_that_can_be_copied(monkeypatch: pytest.MonkeyPatch) -> None:
    lacking = Finding(
        "extra plot", "note", "matplotlib not installed", "pip install 'disknav[plot] @ file:///a'"
    )
    monkeypatch.setattr("deploy.software.findings", lambda: iter([lacking]))
    monkeypatch.setattr("deploy.cli.setup._trial", lambda: Finding("fleet", "bad", "did not run"))
    done = CliRunner().invoke(app, ["setup", "doctor"], catch_exceptions=False)
    assert lacking.remedy in done.stdout
    assert done.exit_code == 1
