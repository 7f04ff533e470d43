"""Every study in small: its rows, summary and table."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
import typer

from deploy.cli.learn import study as command
from deploy.software import provenance
from deploy.studies.conditions import LinkConditions, against, arrival, delay, robustness
from deploy.studies.execution import RunLog, execute
from deploy.studies.experiments import PERIOD, TOLERANCE, paper_flow, scale, tuning
from deploy.studies.perform import table
from deploy.studies.study import Study, error, growth
from protocol.errors import ScenarioError, UsageError
from tests.deploy.printed import printed

pytestmark = pytest.mark.slow

PROMISED = {"tight", "k", "nrl_mean", "nrl_std", "arrived", "runs"}
SMALL: dict[str, Callable[[], Study]] = {
    "robustness": lambda: robustness(1, conditions=[LinkConditions(), LinkConditions(noise=0.001)]),
    "arrival": lambda: arrival(1),
    "scale": lambda: scale(1, robots=(3, 4), transports=("local",)),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.campaign if name == "arrival" else ()) for name in SMALL]
)
def test_a_small_study_from_runs_to_table(name: str) -> None:
    study = SMALL[name]()
    result = execute(study, "local", RunLog(None), jobs=2)
    assert len(result.rows) == len(study.cells)
    assert study.sound(result.rows)
    assert all(set(study.columns.split()) <= set(row) for row in result.rows)
    text = printed(table(study, result.rows))
    assert all(line in text for line in study.summary(result.rows))


small = partial(command, "tightness", runs=1, jobs=2, transport="local", quiet=True)


def test_the_document_has_what_is_promised(tmp_path: Path) -> None:
    target = tmp_path / "rows.json"
    with pytest.raises(typer.Exit) as ended:
        small(setting=["time.step=0.05"], json_file=target)
    assert ended.value.exit_code == 0
    document = json.loads(target.read_text())
    assert document["study"] == "tightness"
    assert [row["tight"] for row in document["rows"]] == [2.44, 2.63, 2.87, 3.30, 3.45]
    assert all(set(row) >= PROMISED for row in document["rows"])
    assert document["provenance"]["seed"] == 0
    assert document["provenance"]["versions"]["numpy"]
    assert document["provenance"]["machine"]["cores"] >= 1


def test_invalid_requests_start_nothing(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="No such file or directory"):
        small(json_file=tmp_path / "nowhere" / "rows.json")
    with pytest.raises(ScenarioError, match="additions"):
        small(setting=['control.additions=["slow"]'])


def test_the_papers_flow_is_bare() -> None:
    scenario = paper_flow("d", 20.0, 3)
    control, time = scenario.control, scenario.time
    found = control.law, control.k, control.additions, control.filter
    assert found == ("gradient", 20.0, ("pace",), "none")
    assert (time.step, time.tolerance) == (PERIOD, TOLERANCE)
    assert [cell.labels["k"] for cell in tuning(1).cells][4:] == [20.0, 30.0, 40.0, 60.0, 100.0, 300.0]


def test_a_collision_under_the_filter_is_not_sound() -> None:
    study = robustness(1, conditions=[LinkConditions()])
    kept, bare = ({"filter": filter_, "collisions": 1} for filter_ in ("separating-lines", "none"))
    assert study.sound([bare])
    assert not study.sound([kept, bare])


def test_statistics() -> None:
    assert growth([1, 2, 4], [3, 12, 48]) == pytest.approx(2.0)
    assert error([1.0]) is None
    assert provenance(7, "local", 2)["seed"] == 7


def test_times_are_compared_seed_by_seed() -> None:
    found = against({"1": 6.0, "2": 9.0, "4": 99.0}, {"1": 4.0, "2": 6.0, "3": 1.0})
    assert found == {"ratio": pytest.approx(1.5), "ratio_error": pytest.approx(0.0)}
    assert against({"1": 6.0}, {"1": 4.0}) == {"ratio": pytest.approx(1.5), "ratio_error": None}
    assert against({"1": 6.0}, {}) == {"ratio": None, "ratio_error": None}


def test_rows_have_both_paces_and_what_delay_costs() -> None:
    study = delay(1, delays=(0.0, 0.1))
    study = replace(study, cells=[cell for cell in study.cells if cell.labels["scenario"] == "tight 3.30"])
    rows = execute(study, "local", RunLog(None), jobs=1).rows
    assert [(row["pace"], row["delay"]) for row in rows] == [
        (pace, late) for pace in ("common", "own") for late in (0.0, 0.1)
    ]
    assert all(row["arrived"] == 1 for row in rows)
    assert study.sound(rows)
    assert rows[0]["ratio"] == 1.0
    assert rows[1]["ratio"] == rows[1]["time_mean"] / rows[0]["time_mean"] > 1.0
    assert len(study.summary(rows)) == 2
    assert all(set(study.columns.split()) <= set(row) for row in rows)
