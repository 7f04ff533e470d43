"""The study of peers: what is scanned, which setting a row shows, what a step costs."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import pytest

from deploy.library import swap
from deploy.studies.peers.contest import best, row, sound, summary
from deploy.studies.peers.study import LAWS, SCANS, contest, peers, places, settings
from deploy.studies.runners.run_log import RunLog
from deploy.studies.runners.runner import execute

pytest.importorskip("pyrvo")
pytest.importorskip("daqp")


def result(**over: Any) -> dict[str, Any]:
    return {
        "verdict": "arrived",
        "arrived": [1, 2],
        "robots": [1, 2],
        "collisions": 0,
        "nrl": 1.2,
        "sim_time": 4.0,
        "ticks": 100,
        "robots_cpu_s": 0.01,
    } | over


def test_a_row_counts_what_came_without_touching() -> None:
    labels = {"scenario": "s", "delay": 0.0, "law": "orca", "horizon": 2.0, "symmetry_noise": 0.1}
    touched = result(verdict="collision", collisions=3, sim_time=1.0)
    stuck = result(verdict="deadlock", arrived=[2])
    found = row(labels, [result(), touched, stuck])
    assert (found["runs"], found["arrived"], found["collisions"], found["reached"]) == (3, 1, 1, 2)
    assert (found["time_mean"], found["nrl_mean"]) == (4.0, 1.2)
    assert found["setting"] == "horizon 2 s, noise 0.1"
    assert found["step_us"] == pytest.approx(50.0)
    assert row(labels, [{"verdict": "failed"}])["step_us"] is None


def test_the_best_setting_arrives_most_then_touches_least_then_is_quickest() -> None:
    rows = [
        {"arrived": arrived, "collisions": touched, "time_mean": time}
        for arrived, touched, time in [(1, 0, 1.0), (2, 2, 1.0), (2, 1, None), (2, 1, 6.0), (2, 1, 5.0)]
    ]
    assert best(rows) is rows[-1]


def test_every_setting_meets_the_same_scenarios_and_stays_in_the_row(tmp_path: Path) -> None:
    study = peers(1, 5, {"pair": partial(swap, 2, 0.01)}, (0.0, 0.1))
    with RunLog(tmp_path / "runs.jsonl") as log:
        rows = execute(study, "local", log, jobs=1).rows
    assert [each["law"] for each in rows] == 2 * list(LAWS)
    assert [each["scenario"] for each in rows][::4] == ["pair", "pair, 100 ms late"]
    assert [len(each["scan"]) for each in rows] == [
        len(list(settings(law, late=late))) for late in (False, True) for law in LAWS
    ]
    assert all(each["runs"] == 1 and each["step_us"] > 0.0 for each in rows)
    assert sound(rows)
    lines = summary(rows)
    assert [line.split(":")[0] for line in lines if not line.startswith(" ")] == list(LAWS)
    assert len(lines) == len(LAWS) + 2 * len(SCANS)  # either method without and with delays
    with RunLog(tmp_path / "runs.jsonl") as log:
        again = execute(study, "local", log, jobs=1)
    assert (again.executed, again.rows) == (0, rows)


@pytest.mark.parametrize("late", [False, True])
def test_either_method_is_tried_with_as_many_settings(late: bool) -> None:
    counts = {law: len(list(settings(law, late=late))) for law in LAWS}
    assert counts["orca"] == counts["barrier"] > counts["gradient"] == counts["gradient + lines"] == 1


def test_a_summary_names_the_single_setting_that_arrives_most() -> None:
    def tried(setting: str, arrived: int, touched: int) -> dict[str, Any]:
        return {"setting": setting, "runs": 3, "arrived": arrived, "collisions": touched}

    scans = [[tried("a", 3, 0), tried("b", 0, 3)], [tried("a", 1, 1), tried("b", 3, 0)]]
    rows = [max(scan, key=lambda each: each["arrived"]) | {"scan": scan} for scan in scans]
    rows = [row | {"law": "orca", "delay": 0.0} for row in rows]
    assert summary(rows) == [
        "orca: 6 of 6 arrived, 0 collided",
        "  without delay: a alone: 4 of 6 arrived, 1 collided; all 2 settings: 7 of 12 arrived, 4 collided",
    ]


def test_a_collision_behind_separating_lines_is_not_sound() -> None:
    assert sound([{"law": "gradient", "collisions": 1}])
    assert not sound([{"law": "gradient + lines", "collisions": 1}])


def test_all_places_can_be_built_and_differ_only_in_the_law() -> None:
    labels = [place.label for place in places()]
    assert len(set(labels)) == len(labels) == 20
    for place in places():
        one, other = (
            contest(place, LAWS[law] | next(settings(law, late=False)), 3) for law in LAWS if law in SCANS
        )
        assert (one.robots, one.link, one.time) == (other.robots, other.link, other.time)
        assert one.link.delay == place.delay
        assert one.control.speed == other.control.speed
