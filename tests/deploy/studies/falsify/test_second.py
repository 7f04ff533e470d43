"""Runs of two scenarios on the same robots: what only the second shows is found, shrunk and kept."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from deploy.library.load import resolved
from deploy.studies.falsify import trial
from deploy.studies.falsify.campaign import Campaign, Plan
from deploy.studies.falsify.files import Files
from deploy.studies.falsify.runs.observe import observe
from deploy.studies.falsify.scenarios.draw import drawn
from deploy.studies.falsify.scenarios.preceding import preceding
from deploy.studies.falsify.trial import Trial, as_second
from deploy.studies.harness.runners.run_log import RunLog
from deploy.studies.harness.study import Run
from protocol.scenario.file import parse_toml, validated
from tests.deploy.studies.falsify.planted import Here, plant, trusting_earlier_sensors

SEED = 23
SHOWING = 8  # a number whose second scenario shows the planted fault


def test_what_goes_before_is_valid_and_leaves_a_mess() -> None:
    firsts = []
    for number in range(60):
        scenario, _ = drawn(SEED, number)
        first = preceding(scenario, number)
        assert first == preceding(scenario, number)
        assert validated(first).ids == scenario.ids
        assert first.workspace == scenario.workspace
        firsts.append((first, scenario))
    events = {fault.event for first, _ in firsts for fault in first.process}
    assert events == {"kill", "pause", "resume", "restart"}
    late = [
        fault
        for first, _ in firsts
        for fault in first.process
        if fault.event == "pause" and first.ticks(first.time.limit - fault.at) <= 3
    ]
    assert len(late) > 10
    assert any(
        {spec.id for spec in first.newcomers} & {spec.id for spec in scenario.newcomers} - {*scenario.ids}
        for first, scenario in firsts
    )
    assert any(first.parts for first, _ in firsts)
    assert any(first.time.limit < scenario.time.limit for first, scenario in firsts)


def test_some_runs_are_the_second_of_two() -> None:
    found = [Trial(partial(drawn, SEED))(Run(0, number, "local", "")) for number in (7, 8, 9)]
    assert [result["follows"] for result in found] == [False, True, True]  # the last is a number of mutants
    assert not any(result["violations"] for result in found)


@pytest.mark.slow
def test_what_only_the_second_shows_is_kept_as_two_files_that_show_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plant(trusting_earlier_sensors, monkeypatch)
    monkeypatch.setitem(trial.TRIES, "local", 12)
    files = Files(tmp_path)
    campaign = Campaign(Plan(SEED, SHOWING + 1, "local"), RunLog(None), files.keep)
    campaign.execute(Here())
    assert campaign.findings
    for finding in campaign.findings:
        assert (finding.number, finding.violation.follows) == (SHOWING, True)
        second, first = files.path(finding), files.path(finding).name.replace("-second", "-first")
        assert first in second.read_text().splitlines()[0]
        two = [resolved(parse_toml(path.read_text())) for path in (tmp_path / first, second)]
        alone = observe(two[1])
        assert alone.violations == []
        assert finding.violation in as_second(*two, alone.trajectory)
    monkeypatch.undo()
    assert as_second(*two, observe(two[1]).trajectory) == []
