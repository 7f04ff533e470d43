"""One sick process costs one robot: real processes on real zenoh."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from deploy.library.load import load
from deploy.run.options import RunOptions
from tests.system.faults.sick import FleetWithOne

pytestmark = [pytest.mark.process, pytest.mark.timeout(150)]


def report_of(fleet: FleetWithOne) -> dict[str, Any]:
    with fleet:
        report = fleet.execute()
        report["processes"] = {process["name"]: process for process in fleet.processes()}
    return report


def test_one_that_dies_between_admission_and_token_is_followed_by_its_successor(tmp_path: Path) -> None:
    options = RunOptions(restarts=1)
    report = report_of(FleetWithOne(load("swap-4"), options, 2, "dies_once_admitted", tmp_path / "admitted"))
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["processes"]["robot-2"]["restarts"] == 1
    assert report["processes"]["robot-2"]["exit_code"] == 0


@pytest.mark.long(10)
def test_one_that_hangs_is_given_up_alone_and_named(capfd: pytest.CaptureFixture[str]) -> None:
    scenario = load("swap-4", ["time.fence=0.3", "time.limit=30.0"])
    report = report_of(FleetWithOne(scenario, RunOptions(), 2, "hangs", 30))
    assert report["arrived"] == [1, 3, 4], (report["verdict"], report["reason"])
    assert report["collisions"] == 0
    given_up = report["faults"]["given_up"]
    assert {each["robot"] for each in given_up} == {2}
    assert given_up[0]["tick"] == 30
    assert re.search("hangs|lack it", given_up[0]["reason"])
    assert "world: tick 30: gives up robot 2, which " in capfd.readouterr().err
    assert all(report["processes"][f"robot-{robot}"]["exit_code"] == 0 for robot in (1, 3, 4))
