"""The study of peers: what is scanned, which setting a row shows."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from deploy.library.encounters import swap
from deploy.studies.execution import RunLog, execute
from deploy.studies.peers import study as venues
from deploy.studies.peers.contest import REFERENCE, Contest, best, row, sound
from deploy.studies.peers.study import LAWS, SCANS, contest, peers, places, settings, with_arguments
from deploy.studies.study import Cell
from protocol import joining
from protocol.errors import UsageError
from protocol.joining import Admission

pytest.importorskip("pyrvo")
pytest.importorskip("daqp")


def result(**over: Any) -> dict[str, Any]:
    usual = {"verdict": "arrived", "arrived": [1, 2], "robots": [1, 2], "collisions": 0, "nrl": 1.2}
    return {**usual, "sim_time": 4.0, "least_time": 2.5, **over}


def test_a_row_counts_what_came_without_touching() -> None:
    labels = {"scenario": "s", "delay": 0.0, "law": "orca", "horizon": 2.0, "noise": 0.1}
    touched = result(verdict="collision", collisions=3, sim_time=1.0)
    stuck = result(verdict="deadlock", arrived=[2])
    found = row(labels, [result(), touched, stuck])
    assert (found["runs"], found["arrived"], found["collisions"], found["reached"]) == (3, 1, 1, 2)
    assert (found["time_mean"], found["nrl_mean"]) == (4.0, 1.2)
    assert (found["time_error"], found["limit_mean"]) == (None, 1.6)
    assert found["setting"] == "horizon 2 s, noise 0.1"


def test_the_best_setting_arrives_most_then_touches_least_then_is_quickest() -> None:
    rows = [
        {"arrived": arrived, "collisions": touched, "time_mean": time}
        for arrived, touched, time in [(1, 0, 1.0), (2, 2, 1.0), (2, 1, None), (2, 1, 6.0), (2, 1, 5.0)]
    ]
    assert best(rows) is rows[-1]


COURTESY = """from agents.law.reciprocal import ReciprocalLaw as Inner
class Courtesy:
    def __init__(self, scenario, robot):
        self.law = Inner(scenario, robot)
    def velocity(self, view):
        return self.law.velocity(view)
"""


@pytest.mark.slow
def test_a_law_of_the_users_runs_beside_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(venues, "places", lambda: [venues.Venue("pair", partial(swap, 2, 0.01))])
    file = tmp_path / "courtesy.py"
    file.write_text(COURTESY, encoding="utf-8")
    name = f"{file}:Courtesy"
    study = peers(2, 5, laws=[name])
    kept = [cell for cell in study.cells if cell.labels["law"] in (REFERENCE, f"{name} + lines")]
    rows = execute(replace(study, cells=kept), "local", RunLog(None), jobs=1).rows
    assert [each["law"] for each in rows] == [REFERENCE, f"{name} + lines"]
    assert [each["paired"] for each in rows] == [2, 2]
    assert rows[1]["time_ratio"] == pytest.approx(1.0, abs=0.1)
    before = kept[1].labels["source"]
    file.write_text(COURTESY + "\n", encoding="utf-8")
    again = peers(2, 5, laws=[name])
    assert {cell.labels.get("source") for cell in again.cells} - {None} != {before}


def test_pairs_are_runs_from_the_same_start() -> None:
    """The second arrives in another run than the first, besides one; only that one counts."""
    labels = {"scenario": "s", "delay": 0.0, "group": "fresh"}
    cells = [
        Cell({**labels, "law": REFERENCE}, partial(swap, 2, 0.01), [0, 1]),
        Cell({**labels, "law": "gradient"}, partial(swap, 2, 0.01), [0, 1]),
    ]
    stuck = result(verdict="timeout")
    results = {(0, 0): result(), (0, 1): result(sim_time=9.0), (1, 0): result(sim_time=6.0), (1, 1): stuck}
    rows = Contest("peers", cells, "", row).rows(results)
    assert (rows[1]["paired"], rows[1]["time_ratio"], rows[1]["time_ratio_error"]) == (1, 1.5, None)


def test_only_named_places_are_visited() -> None:
    labels = {cell.labels["scenario"] for cell in peers(1, only=["swap 1", "Blocks"]).cells}
    assert {"swap 10", "swap 12", "swap 10, 300 ms late", "Blocks"} <= labels
    assert not any(label.startswith(("tight", "random")) for label in labels)
    with pytest.raises(UsageError, match="swap 24"):
        peers(1, only=["swop"])


def test_a_collision_behind_separating_lines_is_not_sound() -> None:
    assert sound([{"law": "gradient", "collisions": 1}])
    assert not sound([{"law": "gradient + lines", "collisions": 1}])


@pytest.mark.slow
def test_all_places_can_be_built_and_differ_only_in_the_law() -> None:
    labels = [place.label for place in places()]
    assert len(set(labels)) == len(labels) == 30
    for place in places()[::4]:
        one, other = (
            contest(place, with_arguments(LAWS[law], next(settings(law, place.group))), 3)
            for law in SCANS[place.group]
        )
        assert joining.decode_reply(joining.encode_reply(Admission(1, True, one))).scenario == one
        assert (one.robots, one.link, one.time) == (other.robots, other.link, other.time)
        assert one.link.delay == place.delay
        assert one.control.speed == other.control.speed
