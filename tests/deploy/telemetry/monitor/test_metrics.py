"""A fleet in figures: what is exported, in which form, and that the example dashboard asks for no other."""

import json
import re
import urllib.request
from itertools import count
from pathlib import Path

import pytest
from prometheus_client.openmetrics.parser import text_string_to_metric_families

from deploy.telemetry.monitor.metrics import PHASES, export
from deploy.telemetry.monitor.snapshot import Source
from protocol.messages import Clock, Health, Truth
from protocol.scenario.model import RobotSpec, Scenario

DASHBOARD = Path(__file__).parents[4] / "docs" / "guides" / "dashboard.json"
SCENARIO = Scenario((RobotSpec(1, 0.03, (0.0, 0.0), (0.1, 0.0)), RobotSpec(2, 0.03, (0.0, 0.2), (0.1, 0.2))))
Figures = dict[tuple[str, tuple[str, ...]], float]


def watched() -> Source:
    """Two robots after some ticks; robot 2 in its second life."""
    seconds = count()
    source = Source("yard", lambda: float(next(seconds)))
    source.change(lambda view, _: view.begin(SCENARIO, False))
    for robot in (None, 1):
        source.change(lambda view, _, robot=robot: view.on_token(robot, True))
    clock = Clock(7, 0.35, (1,), (), "", 0.005, missed=3, rejected={"identity": 4})
    truths = [Truth(tick, (1, 2), ((0.0, 0.0), (0.0, 0.2)), gap, 0.5) for tick, gap in ((6, 0.01), (7, 0.02))]
    healths = [
        Health(robot, life, 7, 0.001, 10, 9, {"shape": 2}, (), ((3 - robot, 1.0, 0.0, 0.1),))
        for robot, life in ((1, 1), (2, 2))
    ]
    for message in (clock, *truths, *healths):
        source.change(lambda view, now, message=message: view.on_message(message, now))
    return source


def asked(address: str) -> Figures:
    request = urllib.request.Request(
        address, headers={"Accept": "application/openmetrics-text; version=1.0.0"}
    )
    with urllib.request.urlopen(request, timeout=10.0) as response:
        assert response.headers["content-type"].startswith("application/openmetrics-text")
        families = text_string_to_metric_families(response.read().decode())
    return {
        (sample.name, tuple(sorted(sample.labels.values()))): sample.value
        for each in families
        for sample in each.samples
    }


def test_what_an_operator_asks_for_is_there() -> None:
    found = asked(export(watched(), "0"))
    assert found["disknav_ticks_total", ()] == 7
    assert found["disknav_missed_commands_total", ()] == 3
    assert found["disknav_clearance_meters", ()] == 0.02
    assert found["disknav_smallest_clearance_meters", ()] == 0.005
    assert found["disknav_rejected_messages_total", ("identity", "world")] == 4
    assert found["disknav_rejected_messages_total", ("robot-2", "shape")] == 2
    assert found["disknav_restarts_total", ("robot-2",)] == 1
    assert found["disknav_present", ("robot-1",)] == 1
    assert found["disknav_present", ("robot-2",)] == 0
    assert found["disknav_lines", ("robot-1",)] == 1
    assert found["disknav_goal_distance_meters", ("robot-1",)] == pytest.approx(0.1)
    assert [phase for phase in PHASES if found["disknav_phase", (phase,)]] == ["running"]
    assert next(name for name in found if name[0] == "disknav_run_info")[1] == ("", SCENARIO.name, "yard")


def test_a_run_that_is_not_there_yet_has_its_phase() -> None:
    found = asked(export(Source("yard"), "127.0.0.1:0"))
    assert found["disknav_phase", ("searching",)] == 1
    assert not any(name == "disknav_ticks_total" for name, _ in found)


def test_the_dashboard_asks_for_what_is_exported() -> None:
    found = {name for name, _ in asked(export(watched(), "0"))}
    asks = [
        target["expr"] for panel in json.loads(DASHBOARD.read_text())["panels"] for target in panel["targets"]
    ]
    assert {name for each in asks for name in re.findall(r"disknav_[a-z_]+", each)} <= found
    assert len(asks) >= 10
