"""The driver: the same for any number of jobs; what is found is kept; Ctrl-C loses nothing."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from tests.campaigns import catalogue, driver
from tests.campaigns.__main__ import main
from tests.campaigns.campaign import Campaign, Dice, Mutant, Outcome
from tests.campaigns.catalogue import CAMPAIGNS, find
from tests.campaigns.driver import attempt, execute, outcomes


def _sum(dice: Dice) -> Outcome:
    """Violated by numbers that add up to more than 100; one run in a few."""
    numbers = [dice.whole(0, 40) for _ in range(dice.whole(0, 6))]
    total = sum(numbers)
    return Outcome("large" if total > 100 else "small", f"{total}" if total > 100 else "", f"{numbers}")


def _fails(_: Dice) -> Outcome:
    raise ZeroDivisionError("planted")


def _goes_on(_: Dice) -> Outcome:
    while time.process_time() < 1000.0:
        pass
    return Outcome("ended")


def _mutants() -> list[Mutant]:
    return [Mutant("found", lambda: (3, "violated")), Mutant("missed", lambda: (9, ""))]


SUM = Campaign(_sum, 40, _mutants)


@pytest.fixture(autouse=True)
def _own_campaign(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(catalogue.CAMPAIGNS, "sum", ("numbers that add up to much", "test_driver:SUM"))


def test_every_campaign_of_the_catalogue_is_one() -> None:
    assert all(find(name).runs > 0 for name in CAMPAIGNS if name != "sum")


def test_all_that_is_found_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sum", "--jobs", "1", "--save", str(tmp_path)]) == 1
    violated = {f"sum-{seed}.txt": found for seed in range(40) if (found := _sum(Dice(seed))).violation}
    assert len(violated) > 3
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {
        name: f"# large: {found.violation}\n\n{found.shows}" for name, found in violated.items()
    }
    assert f"{len(violated)} with a violation" in capsys.readouterr().out


def test_an_exception_and_a_run_that_takes_too_long_are_violations() -> None:
    failed = attempt(Campaign(_fails, 1), Dice(0))
    assert (failed.said, failed.violation) == ("ZeroDivisionError in _fails", "planted")
    assert "planted" in failed.shows
    assert attempt(Campaign(_goes_on, 1, patience=0.05), Dice(0)).said.startswith("TimeoutError")


def test_a_stopped_campaign_says_what_came_of_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: object) -> None:
        yield 0, Outcome("small")
        raise KeyboardInterrupt

    monkeypatch.setattr(driver, "outcomes", stopped)
    said: list[str] = []
    tally = execute("sum", 9, 0, jobs=1, folder=tmp_path, tell=said.append)
    assert (tally.runs, said) == (1, ["stopped"])


def test_no_run_begins_after_its_time() -> None:
    assert len(list(outcomes("sum", range(9), 1, until=0.0))) == 1


def test_mutants_that_are_missed_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sum", "--mutants", "--jobs", "1"]) == 1
    found, missed = capsys.readouterr().out.splitlines()
    assert found.split() == ["found", "3", "violated"]
    assert missed.endswith("NOT FOUND")


@pytest.mark.slow
def test_the_same_whatever_the_number_of_jobs() -> None:
    alone = dict(outcomes("bodies", range(2), 1))
    assert dict(outcomes("bodies", range(2), 2)) == alone
