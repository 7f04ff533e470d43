"""What commands write: to a terminal, to files, and where neither takes it."""

import errno
import io
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from deploy.output import check_target, check_text, whole_folder, write_json, writing
from protocol.errors import UsageError
from protocol.scenario.file import parse_toml
from tests.forks import Forks


def test_what_cannot_be_written_is_refused_beforehand(tmp_path: Path) -> None:
    for target in (tmp_path / "missing" / "result.json", tmp_path):
        with pytest.raises(UsageError, match="cannot write to"):
            check_text(target)
    with pytest.raises(UsageError, match="cannot write to /proc/new"), whole_folder(Path("/proc/new")):
        pytest.fail("there is no such folder")


def test_looking_leaves_nothing_behind_and_spoils_nothing(tmp_path: Path) -> None:
    new, old, pipe, linked = (tmp_path / name for name in ("new.json", "old.json", "pipe", "linked"))
    old.write_text("kept")
    linked.hardlink_to(old)
    os.mkfifo(pipe)
    for target in (new, old, pipe, Path("-"), Path("/dev/null"), None):
        check_text(target)
    assert not new.exists()
    assert old.read_text() == "kept"
    for target in (pipe, linked, Path("-")):
        with pytest.raises(UsageError, match="cannot record to"):
            check_target(target, "record", old)


def test_a_dash_is_standard_output(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_json({"a": 1}, Path("-"))
    write_json({"a": 1}, None)
    assert json.load(io.StringIO(capsys.readouterr().out)) == {"a": 1}
    write_json({"a": 2}, tmp_path / "-")
    assert json.loads((tmp_path / "-").read_text()) == {"a": 2}


def test_what_cannot_be_written_after_all_is_one_line_and_no_half_file(tmp_path: Path) -> None:
    target, there = tmp_path / "half.txt", tmp_path / "there.txt"
    there.write_text("kept")
    for path in (target, there):
        with pytest.raises(UsageError, match=r"cannot draw to .*: No space left"), writing(path, "draw"):
            _fill(path)
    assert not target.exists()
    assert there.read_text() == "kept"


def _fill(path: Path) -> None:
    path.open("a").close()
    raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.parametrize("option", ["--plot", "--json"])
@pytest.mark.slow
def test_a_full_disk_costs_the_file_and_not_the_result(disknav: Forks, tmp_path: Path, option: str) -> None:
    target = tmp_path / "x.png"
    target.symlink_to("/dev/full")
    run = disknav("run", "figure-1", "--transport", "local", option, target)
    assert run.returncode == 2
    assert "figure-1: arrived" in run.stdout
    assert run.stderr.splitlines()[-1].startswith("disknav: cannot ")
    assert "No space left on device" in run.stderr
    assert "Traceback" not in run.stderr


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("command", ["list >/dev/full", "show swap-2 >/dev/full", "show swap-20 >half"])
@pytest.mark.slow
def test_a_full_disk_behind_standard_output_is_a_fault_of_the_machine(
    command: str, unbuffered: str, tmp_path: Path
) -> None:
    call = ["sh", "-c", f"ulimit -f 1; exec {sys.executable} -m disknav scenario {command}"]
    env = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    done = subprocess.run(call, cwd=tmp_path, env=env, capture_output=True, check=False, timeout=60.0)
    why = b"File too large" if "half" in command else b"No space left on device"
    assert (done.returncode, done.stderr) == (3, b"disknav: cannot write to standard output: %b\n" % why)


@pytest.mark.slow
def test_a_terminal_that_lacks_a_character_is_shown_another(tmp_path: Path) -> None:
    """LC_ALL=C without Python's own way out, as a service's environment may be."""
    file = tmp_path / "cafe.toml"
    robot = "id = 1\nradius = 0.04\nstart = [0.0, 0.0]\ngoal = [0.0, 0.0]\n"
    file.write_text(f'name = "café"\n[[robots]]\n{robot}', encoding="utf-8")
    bare = {**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    call = [sys.executable, "-m", "disknav"]
    shown = subprocess.run([*call, "scenario", "show", file], env=bare, capture_output=True, check=True)
    assert parse_toml(shown.stdout.decode()).name == "café"
    checked = subprocess.run([*call, "check", file], env=bare, capture_output=True, check=True)
    assert rb"caf\xe9" in checked.stdout


@pytest.mark.parametrize(
    "command", ["scenario list", "scenario schema", "--version", "run swap-2 --plot x.png"]
)
@pytest.mark.slow
def test_a_reader_that_ends_early_is_told_apart_from_a_verdict(command: str, tmp_path: Path) -> None:
    reads, writes = os.pipe()
    os.close(reads)
    call = [sys.executable, "-m", "disknav", *command.split()]
    with os.fdopen(writes) as unread:
        told = {"stdout": unread, "stderr": subprocess.PIPE, "cwd": tmp_path}
        done = subprocess.run(call, **told, text=True, check=False, timeout=60)
    assert (tmp_path / "x.png").exists() == ("--plot" in command)
    assert done.returncode == 128 + signal.SIGPIPE
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("number", "ending", "status"), [(0, "1 / 0", 3), (2, "1 / 0", 130), (15, "m.STOP.check()", 143)]
)
@pytest.mark.slow
def test_a_fault_is_no_verdict_and_a_signal_decides_anyway(number: int, ending: str, status: int) -> None:
    run = f"lambda: print() or m.os.kill(m.os.getpid(), {number}) or {ending}"
    code = f"from deploy.cli import main as m; m._run = {run}; m.main()"
    call = ["sh", "-c", f"PYTHONUNBUFFERED= exec {sys.executable} -c '{code}' >/dev/full"]
    assert subprocess.run(call, check=False, timeout=60.0).returncode == status


@pytest.mark.parametrize("closed", [">&-", "<&- >&- 2>&-"])
@pytest.mark.slow
def test_standard_files_may_be_closed(closed: str, tmp_path: Path) -> None:
    """Sockets and files of the processes would get their numbers."""
    becomes = 'm._open_standard_files(); m.os.execlp("sh", "sh", "-c", "echo && echo >&2")'
    call = ["sh", "-c", f"exec {sys.executable} -c 'from deploy.cli import main as m; {becomes}' {closed}"]
    subprocess.run(call, check=True, timeout=60.0)
    file = tmp_path / "result.json"
    command = f"run head-on --set time.limit=1 --web --json {file}"
    call = ["sh", "-c", f"exec {sys.executable} -m disknav {command} {closed}"]
    with (tmp_path / "stderr").open("w+") as said:
        done = subprocess.run(call, stderr=said, check=False, timeout=60.0)
        said.seek(0)
        assert "Traceback" not in said.read()
    assert json.loads(file.read_text())["verdict"] == "timeout"
    assert done.returncode == 1
