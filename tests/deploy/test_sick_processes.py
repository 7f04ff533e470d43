"""One sick process costs one robot: real processes on real zenoh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from deploy.load import load
from deploy.options import RunOptions
from tests.deploy.sick import FleetWithOne

pytestmark = [pytest.mark.process, pytest.mark.timeout(150)]


def report_of(fleet: FleetWithOne) -> dict[str, Any]:
    with fleet:
        report = fleet.execute()[0]
        report["processes"] = {process["name"]: process for process in fleet.processes()}
    return report


def test_one_that_dies_between_admission_and_token_is_followed_by_its_successor(tmp_path: Path) -> None:
    options = RunOptions(restarts=1)
    report = report_of(FleetWithOne(load("swap-4"), options, 2, "dies_once_admitted", tmp_path / "admitted"))
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["processes"]["robot-2"]["restarts"] == 1
    assert report["processes"]["robot-2"]["exit_code"] == 0
