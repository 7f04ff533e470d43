"""What other hosts say: labelled, in one place, unable to pass for others or to steer a terminal."""

from __future__ import annotations

import io
import json
from pathlib import Path

import msgspec
import pytest

from deploy.processes.hosts.ssh import Relay

SAID = {
    "time": "2026-11-22T13:56:23.671691Z",
    "level": "warning",
    "run": "yard",
    "host": "base",
    "role": "robot",
    "robot": 3,
    "text": "stands \x1b[2J still",
}
LINES = (
    json.dumps(SAID),
    json.dumps({**SAID, "level": "info", "text": "life 2 begins"}),
    json.dumps({**SAID, "text": "failed:\nworld: all is well"}),
    json.dumps({**SAID, "time": "0001-01-01T00:00:00"}),
    "Welcome to \x1b]0;Debian\x07",
    json.dumps({**SAID, "role": "../../robot"}),
    "x" * 200_000,
)


def test_all_that_a_host_says_is_labelled(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    relay = Relay("left", "yard", tmp_path)
    relay.follow(io.BytesIO("\n".join(LINES).encode()))
    relay.end()
    words = capsys.readouterr().err
    assert words.startswith("left: robot 3: stands  [2J still\n")
    assert "left: robot 3: failed:\nleft: world: all is well\n" in words
    assert "\x1b" not in words
    assert "life 2" not in words
    assert all(line.startswith("left: ") for line in words.splitlines())
    assert [path.name for path in tmp_path.iterdir()] == ["left.jsonl"]
    lines = [msgspec.json.decode(line) for line in (tmp_path / "left.jsonl").read_text().splitlines()]
    assert {line["host"] for line in lines} == {"left"}
    assert [line["role"] for line in lines[:6]] == ["robot", "robot", "robot", "", "", ""]
    assert lines[0]["time"] == SAID["time"]
    assert lines[1]["text"] == "life 2 begins"


def test_what_is_no_text_is_shown_all_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    relay = Relay("left", "yard", None)
    relay.follow(io.BytesIO(b'{"run":"ya\xc6rd"}\n' + b"[" * 5000 + b"\nand then\n"))
    relay.end()
    words = capsys.readouterr().err.splitlines()
    assert words[0] == 'left: {"run":"ya\ufffdrd"}'
    assert words[-1] == "left: and then"
