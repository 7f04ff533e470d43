"""Orders that stand in a scenario: carried out in their ticks, the same on every bus, or refused."""

from pathlib import Path
from typing import Any

import pytest

from deploy.library.load import resolved
from deploy.processes import table
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from deploy.telemetry.recording.reader import read
from protocol.messages import Command
from protocol.scenario.model import Journey, Obstacle, Order, ProcessFault, RobotSpec, Scenario, Time
from tests.campaigns.observe import observe

GUEST = RobotSpec(3, 0.03, (0.2, 0.1), (-0.2, 0.1))
EVERYTHING = resolved(
    Scenario(
        (RobotSpec(1, 0.04, (-0.2, 0.0), (0.2, 0.0)), RobotSpec(2, 0.04, (0.0, -0.2), (0.0, 0.2))),
        process=(ProcessFault(3, 2.4, "restart"),),
        orders=(
            Order(0.5, goal=Journey(1, ((0.1, 0.1), (-0.2, 0.0)))),
            Order(1.0, add=GUEST),
            Order(1.5, place=Obstacle(center=(0.0, 0.0), radius=0.02)),
            Order(2.0, halt=True),
            Order(2.5, halt=False),
            Order(3.0, remove=2),
            Order(3.05, add=RobotSpec(2, 0.02, (0.0, -0.2), (0.0, -0.2))),
            Order(4.0, take=1),
            Order(4.0, take=1),
            Order(4.2, remove=3),
            Order(4.3, goal=Journey(3, ((0.0, 0.0),))),
        ),
    )
)


@pytest.fixture(scope="module")
def report() -> dict[str, Any]:
    return LocalFleet(EVERYTHING).execute()


def test_all_are_carried_out_and_what_cannot_be_is_refused(report: dict[str, Any]) -> None:
    assert (report["verdict"], report["collisions"], report["robots"]) == ("arrived", 0, [1, 2])
    assert [order["tick"] for order in report["orders"]] == [10, 20, 30, 40, 50, 60, 61, 80, 80, 84, 86]
    refused = [order["refused"] for order in report["orders"] if order["refused"]]
    assert len(refused) == 2
    assert refused[0] == "there is no obstacle 1"
    assert "no robot 3" in refused[1]
    assert report["faults"]["given_up"] == []
    assert report["positions"]["1"] == pytest.approx((-0.2, 0.0), abs=0.006)
    assert report["positions"]["2"] == pytest.approx((0.0, -0.2), abs=0.006)
    assert report["path_lengths"]["2"] > 0.1  # of both that had this id


@pytest.mark.process
@pytest.mark.timeout(60)
def test_real_processes_drive_the_same_trajectory(report: dict[str, Any], tmp_path: Path) -> None:
    with Fleet(EVERYTHING, RunOptions("mesh"), record=tmp_path / "run.mcap") as fleet:
        found = fleet.execute()
        rows = [row for row in fleet.processes() if row["name"] != table.RECORDER]
        fleet.record(found)
    commands = read(tmp_path / "run.mcap").messages(Command)
    assert {each.robot: each.tick for each in reversed([*commands])} == {1: 0, 2: 0, 3: 21}
    assert found["trajectory_sha256"] == report["trajectory_sha256"]
    assert found["faults"]["given_up"] == []
    assert {row["name"] for row in rows} == {"world", "robot-1", "robot-2", "robot-3"}
    assert {row["exit_code"] for row in rows} == {0}


def test_a_later_life_of_one_process_hears_peers_that_the_first_did_not_know() -> None:
    """Fenced while a robot is added, it joins again, and waits for that robot's States."""
    guest = RobotSpec(2, 0.04, (0.0, 0.1), (0.0, 0.1))
    scenario = Scenario(
        (RobotSpec(1, 0.03, (0.0, 0.0), (0.0, -0.2)),),
        time=Time(limit=6.0),
        process=(ProcessFault(1, 0.4, "pause"), ProcessFault(1, 4.0, "resume")),
        orders=(Order(2.0, add=guest),),
    )
    seen = observe(resolved(scenario))
    assert seen.violations == []
    assert (seen.report["verdict"], seen.report["faults"]["given_up"]) == ("arrived", [])
