"""The log of finished runs: what was written is known again, what was cut short is not."""

from __future__ import annotations

from pathlib import Path

from deploy.studies.harness.runners.run_log import RunLog


def test_results_are_known_to_the_next_log(tmp_path: Path) -> None:
    with RunLog(tmp_path / "log") as log:
        log.add("a", {"nrl": 1.5})
        log.add("b", {"nrl": None})
    assert RunLog(tmp_path / "log").known == {"a": {"nrl": 1.5}, "b": {"nrl": None}}


def test_a_torn_last_line_is_ignored_and_does_not_spoil_the_next(tmp_path: Path) -> None:
    path = tmp_path / "log"
    with RunLog(path) as log:
        log.add("a", {"nrl": 1.5})
        log.add("b", {"nrl": 2.5})
    path.write_bytes(path.read_bytes()[:-9])
    with RunLog(path) as log:
        assert log.known == {"a": {"nrl": 1.5}}
        log.add("c", {"nrl": 3.5})
    assert RunLog(path).known == {"a": {"nrl": 1.5}, "c": {"nrl": 3.5}}


def test_fresh_forgets(tmp_path: Path) -> None:
    with RunLog(tmp_path / "log") as log:
        log.add("a", {})
    assert RunLog(tmp_path / "log", fresh=True).known == {}
