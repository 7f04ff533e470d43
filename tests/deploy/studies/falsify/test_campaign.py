"""Campaigns: the same whatever the workers, gone on with after a stop, and everything found is kept."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from deploy.library.load import resolved
from deploy.output.exit_status import EXIT_ARRIVED, EXIT_INTERRUPTED, EXIT_OTHERWISE
from deploy.studies.falsify import campaign as module
from deploy.studies.falsify import perform as command
from deploy.studies.falsify import trial
from deploy.studies.falsify.archive import Archive, Entry
from deploy.studies.falsify.campaign import Campaign, Finding, Plan
from deploy.studies.falsify.runs.nearness import nearness
from deploy.studies.falsify.runs.observe import observe
from deploy.studies.falsify.runs.on_processes import on_processes
from deploy.studies.falsify.runs.violation import Violation, violations
from deploy.studies.falsify.scenarios.dice import Dice
from deploy.studies.falsify.scenarios.draw import drawn
from deploy.studies.falsify.trial import Trial, perform
from deploy.studies.harness.request import Request
from deploy.studies.harness.runners.run_log import RunLog
from deploy.studies.harness.runners.worker_pool import WorkerPool
from deploy.studies.harness.study import Run
from deploy.studies.perform import perform as study
from protocol.errors import ScenarioError, UsageError
from protocol.scenario.file import parse_toml
from tests.deploy.studies.falsify.planted import Here, not_waiting, plant

pytestmark = pytest.mark.slow

PLAN = Plan(57, 12, "local")


@pytest.fixture(autouse=True)
def _small_generations(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "GENERATION", 8)


def _without_times(campaign: Campaign) -> dict[Any, Any]:
    return {key: {**result, "seconds": 0.0} for key, result in campaign.results.items()}


def _executed(plan: Plan, log: RunLog, workers: module.Workers) -> Campaign:
    campaign = Campaign(plan, log)
    campaign.execute(workers)
    return campaign


def test_the_same_whatever_the_number_of_workers() -> None:
    alone = _executed(PLAN, RunLog(None), Here())
    with WorkerPool(2, perform) as crew:
        together = _executed(PLAN, RunLog(None), crew)
    assert json.loads(json.dumps(list(_without_times(alone).values()))) == json.loads(
        json.dumps([_without_times(together)[key] for key in alone.results])
    )
    assert {cell for cell, _ in alone.results} == {module.FRESH, module.MUTANT}


def test_a_campaign_that_was_stopped_goes_on(tmp_path: Path) -> None:
    with RunLog(tmp_path / "log") as log:
        _executed(replace(PLAN, runs=8), log, Here())
    with RunLog(tmp_path / "log") as log:
        workers = Here()
        whole = _executed(PLAN, log, workers)
    assert workers.performed == 4
    assert _without_times(whole).keys() == _without_times(_executed(PLAN, RunLog(None), Here())).keys()


def test_other_seeds_and_settings_reuse_nothing() -> None:
    keys = {
        plan.run(0, 7).key
        for plan in (
            PLAN,
            replace(PLAN, seed=4),
            replace(PLAN, settings=("link.loss=0",)),
            replace(PLAN, code="x"),
        )
    }
    assert len(keys) == 4
    assert replace(PLAN, runs=9).run(0, 7) == PLAN.run(0, 7)


def test_settings_are_laid_over_every_scenario() -> None:
    scenario, _ = Trial(partial(drawn, 0), ("control.law=orca", "time.limit=3.0")).scenario(5)
    assert (scenario.control.law, scenario.time.limit) == ("orca", 3.0)


def test_the_nearest_of_each_niche_are_kept() -> None:
    archive, (scenario, _) = Archive(), drawn(0, 0)
    archive.add(("wall",), Entry(1.0, 0, scenario))
    assert not archive.wants(("wall",), 0.5)
    assert archive.wants(("wall",), 1.0)
    assert archive.wants(("pair",), 0.0)
    archive.add(("wall",), Entry(2.0, 1, drawn(0, 1)[0]))
    assert len(archive) == 1
    assert archive.parents(Dice(0, 0, 9))[0] == drawn(0, 1)[0]


# -- what is a violation


def _report(**changes: object) -> dict[str, Any]:
    return {"contacts": [], "verdict": "timeout", "reason": "", "min_clearance": 0.1, **changes}


def test_what_is_a_violation() -> None:
    touch = {"pair": [1, 2], "from": 0.5, "until": 1.0, "deepest": -0.01}
    wall = {"pair": [0, 2], "from": 0.5, "until": 1.0, "deepest": -0.02}
    assert violations(_report()) == []
    assert violations(_report(verdict="aborted", reason="robot 3 is down for good")) == []
    assert [each.kind for each in violations(_report(contacts=[touch, wall, touch]))] == ["contact", "wall"]
    assert "robots 1 and 2 overlap by 0.01 m" in violations(_report(contacts=[touch]))[0].text
    (gave_up,) = violations(_report(verdict="aborted", reason="no sign of robot 1 within 20 s"))
    assert gave_up.kind == "aborted"
    assert violations(_report(min_clearance=float("nan")))[0].kind == "error"


def test_robots_without_lines_are_exposed_before_they_touch(monkeypatch: pytest.MonkeyPatch) -> None:
    """Settled robots never are; a robot that moves before it has lines is, whether or not it touches."""

    def scores() -> list[float]:
        found = []
        for number in range(6):
            scenario, _ = drawn(0, number)
            seen = observe(scenario)
            assert seen.report is not None
            found.append(nearness(scenario, seen.truths, seen.sides, seen.report["faults"]).score)
        return found

    assert max(scores()) < 100.0
    plant(not_waiting, monkeypatch)
    assert max(scores()) > 1000.0


# -- the command


def _request(folder: Path, **changes: object) -> Request:
    usual = {
        "name": "falsify",
        "runs": 12,
        "jobs": 1,
        "scheduler": None,
        "seed": 0,
        "settings": (),
        "transport": None,
        "random": None,
        "target": folder / "rows.json",
        "plot": None,
        "fresh": False,
        "quiet": True,
        "found": folder / "found",
    }
    return Request(**{**usual, **changes})  # type: ignore[arg-type]


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """The command's workers are this thread, so that a planted fault is theirs."""

    class Crewless(Here):
        def __init__(self, *_: object) -> None:
            super().__init__()

        def __enter__(self) -> Crewless:
            return self

        def __exit__(self, *_: object) -> None:
            """Nobody has to leave."""

    monkeypatch.setattr(command, "WorkerPool", Crewless)
    monkeypatch.setitem(trial.TRIES, "local", 10)


def test_nothing_found(tmp_path: Path) -> None:
    assert study(_request(tmp_path, settings=("process=[]", "sensing={}"))) == EXIT_ARRIVED
    document = json.loads((tmp_path / "rows.json").read_text())
    assert document["study"] == "falsify"
    assert sum(row["runs"] for row in document["rows"]) == 12
    assert document["violations"] == []
    assert document["provenance"]["complete"]
    assert not (tmp_path / "found").exists()


@pytest.mark.usefixtures("here")
def test_what_is_found_is_kept_as_files_that_show_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plant(not_waiting, monkeypatch)
    assert study(_request(tmp_path, runs=8, quiet=False)) == EXIT_OTHERWISE
    violations_ = json.loads((tmp_path / "rows.json").read_text())["violations"]
    assert violations_
    for each in violations_:
        file = Path(each["file"])
        text, first = file.read_text(), file.with_name(file.name.replace("-second", "-first"))
        assert text.startswith("# ")
        before = [] if first == file else [resolved(parse_toml(first.read_text()))]
        shown = observe(resolved(parse_toml(text)), before=before).violations
        assert each["kind"] in {violation.kind for violation in shown}
    assert violations_[0]["file"].split("/")[-1] in capsys.readouterr().out.replace("\n", "")


@pytest.mark.usefixtures("here")
def test_stopped_in_the_middle_it_keeps_what_it_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plant(not_waiting, monkeypatch)
    advance = command.StudyProgress.count

    def stop_after_a_finding(self: Any, said: str) -> None:
        advance(self, said)
        if not said.startswith("0"):
            raise KeyboardInterrupt

    monkeypatch.setattr(command.StudyProgress, "count", stop_after_a_finding)
    assert study(_request(tmp_path)) == EXIT_OTHERWISE
    assert len(list((tmp_path / "found").iterdir())) >= 1
    assert not json.loads((tmp_path / "rows.json").read_text())["provenance"]["complete"]


@pytest.mark.usefixtures("here")
def test_stopped_before_anything_was_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(command.StudyProgress, "count", stop)
    assert study(_request(tmp_path)) == EXIT_INTERRUPTED


def test_bad_options(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="not a folder"):
        study(_request(tmp_path, found=tmp_path / "file"))
    with pytest.raises(UsageError, match="plot"):
        study(_request(tmp_path, plot=tmp_path / "a.png"))
    with pytest.raises(UsageError, match="cannot write"):
        study(_request(tmp_path, target=tmp_path / "nowhere" / "rows.json"))
    with pytest.raises(ScenarioError):
        study(_request(tmp_path, settings=("control.law=none",)))


# -- real processes


@pytest.mark.process
@pytest.mark.timeout(90)
def test_real_processes_drive_the_same_trajectory() -> None:
    scenario = next(
        s for s, _ in (drawn(0, n) for n in range(99)) if len(s.robots) == 3 and len(s.process) == 2
    )
    trajectory = observe(scenario).trajectory
    assert on_processes(scenario, "mesh", trajectory) == []
    (other,) = on_processes(scenario, "routed", "0" * 64)
    assert other.kind == "bus"
    assert trajectory[:12] in other.text


def test_a_finding_names_its_making() -> None:
    """Errors of one place are of one making, contacts all are."""
    one, other = Violation("error", "a", "ValueError in f"), Violation("error", "b", "ValueError in g")
    assert one.making != other.making
    assert Violation("contact", "a").making == Violation("contact", "b").making
    assert Finding(0, 1, one, "").tried == 0
    assert Run(0, 1, "local", "k").key == "k"
