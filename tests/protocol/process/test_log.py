"""What processes say: words for people, lines for machines, and nothing that can stop a process."""

import json
import logging
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from protocol.errors import UsageError
from protocol.process import log
from tests.scripts import ended

SAYS = """
import sys
from pathlib import Path
from protocol.process import log
log.begin("launcher")
log.begin("robot-3", "yard", Path(sys.argv[1]) if sys.argv[1] else None, wired=bool(sys.argv[2]))
log.LOG.info("life 1 begins")
log.LOG.warning("100 % of ü is here")
try:
    1 / 0
except ZeroDivisionError:
    log.LOG.exception("failed:")
"""


def said(folder: Path | str, *, wired: bool = False) -> str:
    done = ended(SAYS, folder, "yes" if wired else "", timeout=60.0)
    assert (done.returncode, done.stdout) == (0, "")
    return done.stderr


def lines(text: str) -> list[dict[str, Any]]:
    return [json.loads(each) for each in text.splitlines()]


def test_words_on_the_terminal_and_lines_in_a_file_to_which_the_next_process_appends(tmp_path: Path) -> None:
    folder = tmp_path / "deep" / "logs"
    for _ in range(2):
        words = said(folder)
    assert words.startswith("robot 3: 100 % of ü is here\nrobot 3: failed:\nTraceback ")
    assert [path.name for path in folder.iterdir()] == ["robot-3.jsonl"]
    found = lines((folder / "robot-3.jsonl").read_text(encoding="utf-8"))
    assert [each["level"] for each in found] == ["info", "warning", "error"] * 2
    whose = {key: found[0][key] for key in ("run", "host", "role", "robot")}
    assert whose == {"run": "yard", "host": "", "role": "robot", "robot": 3}
    assert datetime.now(UTC) - datetime.fromisoformat(found[-1]["time"]) < timedelta(minutes=5)
    assert found[2]["text"].endswith("ZeroDivisionError: division by zero")


def test_over_a_wire_there_are_lines_alone() -> None:
    assert [each["text"] for each in lines(said("", wired=True))][:2] == [
        "life 1 begins",
        "100 % of ü is here",
    ]


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match=r"cannot log to .*world.jsonl: .*; name a folder"):
        log.lines(log.Speaker(), tmp_path / "file" / "world.jsonl")


def test_a_file_that_was_moved_away_is_begun_anew(tmp_path: Path) -> None:
    handler = log.lines(log.Speaker(), tmp_path / "a.jsonl")
    record = logging.LogRecord("", logging.INFO, "", 0, "said", (), None)
    handler.emit(record)
    (tmp_path / "a.jsonl").rename(tmp_path / "a.1")
    handler.emit(record)
    handler.close()
    assert all(len(lines(path.read_text())) == 1 for path in tmp_path.iterdir())
    assert len(list(tmp_path.iterdir())) == 2


def test_a_full_disk_costs_lines_and_one_word(capsys: pytest.CaptureFixture[str]) -> None:
    handler = log.lines(log.Speaker(), Path("/dev/full"))
    for _ in range(3):
        handler.handle(logging.LogRecord("", logging.INFO, "", 0, "said", (), None))
    assert re.fullmatch(r"disknav: cannot log to /dev/full: .*No space left.*lost\n", capsys.readouterr().err)
