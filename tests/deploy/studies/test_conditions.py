"""The study of late states: every run against the one without delay."""

from __future__ import annotations

from dataclasses import replace

import pytest

from deploy.studies.conditions import against, delay
from deploy.studies.execution import RunLog, execute


def test_times_are_compared_seed_by_seed() -> None:
    found = against({"1": 6.0, "2": 9.0, "4": 99.0}, {"1": 4.0, "2": 6.0, "3": 1.0})
    assert found == {"ratio": pytest.approx(1.5), "ratio_error": pytest.approx(0.0)}
    assert against({"1": 6.0}, {"1": 4.0}) == {"ratio": pytest.approx(1.5), "ratio_error": None}
    assert against({"1": 6.0}, {}) == {"ratio": None, "ratio_error": None}


@pytest.mark.slow
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


def test_a_row_whose_runs_without_delay_are_missing_has_no_ratio() -> None:
    study = delay(1)
    late = {"seed": 0, "verdict": "arrived", "collisions": 0, "nrl": 1.2, "sim_time": 5.0}
    assert [row["ratio"] for row in study.rows({(1, 0): late})] == [None]
    assert not study.sound(study.rows({(1, 0): late | {"collisions": 1}}))
