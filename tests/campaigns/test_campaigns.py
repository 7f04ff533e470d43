"""A share of the campaigns in every run of the suite, and their driver: what is found is kept, and told."""

import time
from collections import Counter
from pathlib import Path

import pytest

from tests.agents.bodies import test_rides as of_bodies
from tests.agents.lines.models import test_models as of_lines
from tests.agents.parts import test_haul as of_parts
from tests.campaigns import catalogue, endurance, planted
from tests.campaigns.__main__ import main
from tests.campaigns.campaign import Campaign, Dice, Outcome
from tests.campaigns.catalogue import CAMPAIGNS, find
from tests.campaigns.driver import attempt
from tests.campaigns.falsify import LOCAL
from tests.campaigns.fuzz.campaign import FUZZ, TARGETS
from tests.interpreted import _compiled


def _sum(dice: Dice) -> Outcome:
    """Violated by numbers that add up to more than 100; one run in a few."""
    numbers = [dice.whole(0, 40) for _ in range(dice.whole(0, 6))]
    total = sum(numbers)
    return Outcome("large" if total > 100 else "small", f"{total}" if total > 100 else "", f"{numbers}")


def _goes_on(dice: Dice) -> Outcome:
    if dice.seed:
        raise ZeroDivisionError("planted")
    while time.process_time() < 1000.0:
        pass
    return Outcome("ended")


SUM = Campaign(_sum, 40)


def test_every_campaign_of_the_catalogue_is_one() -> None:
    assert all(find(name).runs > 0 for name in CAMPAIGNS)


def test_every_mutant_changes_words_that_the_sources_say() -> None:
    faults = (*planted.FAULTS, planted.SIZING, planted.HEARING)
    for mutant in (*of_lines.MUTANTS, *of_bodies.MUTANTS, *of_parts.MUTANTS, *faults):
        for module in {edit.module for edit in mutant.edits}:
            _compiled(module, tuple(edit for edit in mutant.edits if edit.module == module))


def test_all_that_is_found_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(catalogue.CAMPAIGNS, "sum", ("numbers that add up to much", "test_campaigns:SUM"))
    assert main(["sum", "--jobs", "1", "--save", str(tmp_path)]) == 1
    violated = {f"sum-{seed}.txt": found for seed in range(40) if (found := _sum(Dice(seed))).violation}
    assert len(violated) > 3
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {
        name: f"# large: {found.violation}\n\n{found.shows}" for name, found in violated.items()
    }
    assert f"{len(violated)} with a violation" in capsys.readouterr().out


def test_an_exception_and_a_run_that_takes_too_long_are_violations() -> None:
    failed = attempt(Campaign(_goes_on, 1), Dice(1))
    assert (failed.said, failed.violation) == ("ZeroDivisionError in _goes_on", "planted")
    assert "planted" in failed.shows
    assert attempt(Campaign(_goes_on, 1, patience=0.05), Dice(0)).said.startswith("TimeoutError")


@pytest.mark.slow
def test_damaged_input_raises_nothing_but_declared_errors() -> None:
    outcomes = [attempt(FUZZ, Dice(seed)) for seed in range(6000)]
    assert [each.shows for each in outcomes if each.violation] == []
    said = Counter(each.said for each in outcomes)
    assert all(said[f"{name}, accepted"] for name in TARGETS)
    assert all(said[f"{name}, refused"] for name in TARGETS.keys() - {"log"})  # it shows what it cannot read


@pytest.mark.slow
def test_nothing_goes_wrong_in_random_scenarios() -> None:
    assert [found for seed in range(6) if (found := attempt(LOCAL, Dice(seed)).violation)] == []


@pytest.mark.campaign
@pytest.mark.process
@pytest.mark.timeout(90)
def test_a_fleet_outlasts_deaths_of_its_processes() -> None:
    outcome = endurance.run(Dice(1), robots=3, seconds=6.0, kill_every=2.0)
    assert outcome.violation == "" or "missed commands" in outcome.violation  # of a busy machine
    assert outcome.figures["kills"] > 0
    assert outcome.figures["ticks"] > 10
