"""The fuzzer: a few thousand inputs for every test run, and what it does with a find."""

from __future__ import annotations

import dataclasses
from collections import Counter
from pathlib import Path

import pytest

from protocol.errors import MessageError
from tests.campaigns.__main__ import main
from tests.campaigns.campaign import Dice
from tests.campaigns.driver import attempt
from tests.campaigns.fuzz.campaign import FUZZ, TARGETS, drawn, target_of


@pytest.mark.slow
def test_nothing_but_declared_errors() -> None:
    outcomes = [attempt(FUZZ, Dice(seed)) for seed in range(8000)]
    assert [each.shows for each in outcomes if each.violation] == []
    said = Counter(each.said for each in outcomes)
    assert all(said[f"{name}, accepted"] for name in TARGETS)
    assert all(
        said[f"{name}, refused"] for name in TARGETS.keys() - {"log"}
    )  # that shows what it cannot read


@pytest.mark.slow
def test_an_input_is_drawn_from_its_seed_alone() -> None:
    assert repr(drawn(41)) == repr(drawn(41))
    assert len({repr(drawn(n)) for n in range(200)}) > 150
    assert {target_of(n) for n in range(sum(each.share for each in TARGETS.values()))} == set(TARGETS)


@pytest.mark.slow
def test_a_find_is_saved(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(given: object) -> bool:
        if "a" in str(given):
            raise KeyError("a")
        raise MessageError("shape", "as declared")

    monkeypatch.setitem(TARGETS, "steer", dataclasses.replace(TARGETS["steer"], read=broken))
    assert main(["fuzz", "--runs", "200", "--seed", "5", "--jobs", "1", "--save", str(tmp_path)]) == 1
    saved = next(iter(tmp_path.iterdir()))
    assert "KeyError: 'a'" in saved.read_text()
    assert f"seed {saved.stem.rpartition('-')[2]}: steer, KeyError" in capsys.readouterr().out
