"""The fuzzer itself: a few thousand inputs for every test run, and what it does with a find."""

from __future__ import annotations

import dataclasses
import sys

import pytest

from protocol.errors import MessageError
from tests.fuzz import __main__ as fuzz
from tests.fuzz.campaign import campaign, drawn, target_of
from tests.fuzz.catalogue import TARGETS


@pytest.mark.slow
def test_nothing_but_declared_errors() -> None:
    tally = campaign(0, range(8000))
    assert list(map(str, tally.findings.values())) == []
    assert all(tally.accepted[name] for name in TARGETS)
    assert all(tally.refused[name] for name in TARGETS.keys() - {"log"})  # that shows what it cannot read


@pytest.mark.slow
def test_an_input_is_drawn_from_its_number_alone() -> None:
    assert repr(drawn(3, 41)) == repr(drawn(3, 41))
    assert len({repr(drawn(3, n)) for n in range(200)}) > 150
    assert {target_of(n) for n in range(sum(each.share for each in TARGETS.values()))} == set(TARGETS)


def test_a_find_is_saved(monkeypatch: pytest.MonkeyPatch, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    def broken(drawn: object) -> bool:
        if "a" in str(drawn):
            raise KeyError("a")
        raise MessageError("shape", "as declared")

    monkeypatch.setitem(TARGETS, "steer", dataclasses.replace(TARGETS["steer"], read=broken))
    call = ["tests.fuzz", "--inputs", "200", "--seed", "5", "--save", str(tmp_path / "found")]
    monkeypatch.setattr(sys, "argv", call)
    assert fuzz.main() == 1
    (saved,) = (tmp_path / "found").iterdir()
    assert "KeyError: 'a'" in saved.read_text()
    number = saved.stem.rpartition("-")[2]
    assert f"--seed 5 --first {number} --inputs 1" in capsys.readouterr().out
