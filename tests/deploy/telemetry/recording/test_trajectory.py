"""Recordings of runs in which robots come and go: read, checked, drawn, exported."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.telemetry.plot.draw import until
from deploy.telemetry.recording.reader import RecordedRun, Truths, read
from deploy.telemetry.recording.replay import participants, verify
from protocol.errors import RecordingError
from protocol.messages import State
from protocol.scenario.model import Order, RobotSpec, Scenario
from tests.deploy.telemetry.recording.recorded import said_by

STEP = 0.05  # s
GUEST = RobotSpec(5, 0.03, (0.0, 0.0), (0.0, 0.2))
ORDERS = (Order(0.2, add=GUEST), Order(1.0, remove=2))


def recorded(scenario: Scenario, path: Path) -> Path:
    with LocalFleet(scenario, record=path) as fleet:
        fleet.execute()
    return path


def course() -> Scenario:
    return replace(load("swap-3", ["time.limit=3.0"]), orders=ORDERS)


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recorded") / "come.mcap"
    return recorded(course(), path)


@pytest.fixture
def recording(path: Path) -> RecordedRun:
    return read(path)


def there(recording: RecordedRun, robot: int) -> list[int]:
    """Ticks in which its disk was there."""
    index = recording.truths.robots.tolist().index(robot)
    return recording.truths.ticks[~np.isnan(recording.truths.positions[:, index, 0])].tolist()


def test_each_is_where_it_was_while_it_was_there(recording: RecordedRun) -> None:
    last = int(recording.truths.ticks[-1])
    assert recording.truths.robots.tolist() == [1, 2, 3, 5]
    assert there(recording, 1) == list(range(last + 1))
    assert there(recording, 2) == list(range(21))
    assert there(recording, 5)[0] > 4
    assert there(recording, 5)[-1] == last
    assert said_by(recording, State, 5)


def without(recording: RecordedRun, lost: int) -> RecordedRun:
    truths, keep = recording.truths, recording.truths.ticks != lost
    columns = (truths.ticks, truths.positions, truths.clearance, truths.phi, truths.log_potential)
    return replace(recording, truths=Truths(truths.robots, *(column[keep] for column in columns)))


def test_a_lost_truth_is_worked_out_unless_somebody_came_or_went(recording: RecordedRun) -> None:
    found = verify(without(recording, 30))
    assert found is not None
    assert (found.sha256, found.restored) == (recording.result["trajectory_sha256"], 1)
    with pytest.raises(RecordingError, match="robots came or went before tick 22"):
        verify(without(recording, 21))


@pytest.mark.slow
def test_a_robot_that_takes_up_a_part_leaves_the_trajectory_the_results(tmp_path: Path) -> None:
    recording = read(recorded(load("parts-3"), tmp_path / "parts.mcap"))
    found = verify(recording)
    assert found is not None
    assert found.sha256 == recording.result["trajectory_sha256"]


def test_participants_have_what_is_known_of_them(recording: RecordedRun) -> None:
    found = {each.robot: each for each in participants(recording)}
    assert (found[5].radius, found[5].goal) == (GUEST.radius, GUEST.goal)
    assert found[5].known[0] == pytest.approx(GUEST.start)
    operated = replace(recording, scenario=replace(recording.scenario, orders=()))
    (guest,) = (each for each in participants(operated) if each.robot == 5)
    assert (guest.radius, guest.goal) == (GUEST.radius, None)  # by the roster; nobody says where it went
    assert [each.robot for each in participants(until(recording, 0.1))] == [1, 2, 3]


def test_the_scene_has_each_while_it_is_there(path: Path) -> None:
    drawn: list[tuple[float, list[str]]] = []
    with path.open("rb") as file:
        for _, _, message in make_reader(file).iter_messages(["/scene/robots"]):
            robots = [each["id"] for each in json.loads(message.data)["entities"]]
            if not drawn or drawn[-1][1] != robots:  # else one was fenced, or is no longer
                drawn.append((message.log_time / 1e9, robots))
    before = ["robot 1", "robot 2", "robot 3"]
    assert drawn == [
        (0.0, before),
        (pytest.approx(STEP * there(read(path), 5)[0]), [*before, "robot 5"]),
        (pytest.approx(STEP * 21), ["robot 1", "robot 3", "robot 5"]),
    ]
