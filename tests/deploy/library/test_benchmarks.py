"""Files of other planners' benchmarks, and what is said of those that no scenario can express."""

import json
from pathlib import Path

import pytest

from deploy.library.benchmarks import Options, imported
from protocol.errors import DocumentError, UsageError
from protocol.scenario.file import parse_toml, write_toml

CBS = """
environment:
  min: [0, 0]
  max: [5.0, 4.0]
  obstacles:
    - {type: box, center: [2.5, 1.0], size: [1.0, 2.0]}
robots:
  - {type: single_integrator_0, start: [0.5, 0.5], goal: [4.5, 0.5]}
  - {type: unicycle_first_order_0_sphere, start: [4.0, 3.0, 1.57], goal: [1.0, 3.0, 0]}
"""
LSC = {
    "quadrotors": {"crazyflie": {"max_vel": [1.0, 0.8, 1.0], "max_acc": [2, 2, 2], "radius": 0.15}},
    "world": [{"dimension": [-5.0, -4.0, 0.0, 5.0, 4.0, 2.5]}],
    "agents": [{"type": "crazyflie", "cid": 1, "start": [4.0, 0.0, 1], "goal": [-4.0, 0.0, 1]}],
    "obstacles": [{"type": "spin"}],
}
OCTILE = "type octile\nheight 3\nwidth 5\nmap\n.....\n..@T.\nS....\n"
SCEN = "version 1\n0 some/m.map 5 3 0 0 4 2 6\n0 some/m.map 5 3 0 0 4 0 4\n0 some/m.map 5 3 4 0 0 0 4\n"
SMG = """<?xrml version='1.0' encoding='utf-8'?>
<root>
  <agents number="1" type="orca"><default_parameters size="0.3" movespeed="1"/>
    <agent id="0" start.xr="2.0" start.yr="4.0" goal.xr="2.0" goal.yr="1.0"/></agents>
  <obstacles number="1"><obstacle><vertex xr="3" yr="2"/><vertex xr="3" yr="3"/>
    <vertex xr="6" yr="2"/><vertex xr="6" yr="3"/></obstacle></obstacles>
  <map><width>8</width><height>6</height><cellsize>1</cellsize><grid><row>0 0 0</row></grid></map>
</root>
"""


def file(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text)
    return folder / name


def test_db_cbs_gives_each_kind_its_disk_and_names_what_is_lost(tmp_path: Path) -> None:
    scenario = imported(file(tmp_path, "a.yaml", CBS), Options())
    assert [(each.radius, each.start, each.goal) for each in scenario.robots] == [
        (0.1, (0.5, 0.5), (4.5, 0.5)),
        (0.4, (4.0, 3.0), (1.0, 3.0)),
    ]
    assert scenario.obstacles[0].points == ((2.0, 0.0), (3.0, 0.0), (3.0, 2.0), (2.0, 2.0))
    assert scenario.workspace.shape.box == ((0.0, 0.0), (5.0, 4.0))
    assert "Not taken over: headings" in scenario.description
    assert parse_toml(write_toml(scenario)) == scenario


def test_lsc_dr_takes_boxes_of_its_world_file_and_names_what_moves(tmp_path: Path) -> None:
    world = file(tmp_path, "w.csv", "1.0,2.0,1.25,0.5,1.0,2.5\n")
    scenario = imported(file(tmp_path, "m.json", json.dumps(LSC)), Options(obstacles=world))
    assert scenario.robots[0].radius == 0.15
    assert scenario.control.speed == 0.8
    assert scenario.obstacles[0].shape.box == ((0.75, 1.5), (1.25, 2.5))
    assert "1 obstacles that move" in scenario.description


def test_moving_ai_counts_rows_from_the_north_and_gives_every_robot_cells_of_its_own(tmp_path: Path) -> None:
    file(tmp_path, "m.map", OCTILE)
    scenario = imported(file(tmp_path, "m.scen", SCEN), Options(robots=2, radius=0.3))
    assert [(each.start, each.goal) for each in scenario.robots] == [
        ((0.5, 2.5), (4.5, 0.5)),
        ((4.5, 2.5), (0.5, 2.5)),
    ]
    boxes = sorted(obstacle.shape.box for obstacle in scenario.obstacles)
    assert boxes == [((0.0, 0.0), (1.0, 1.0)), ((2.0, 1.0), (4.0, 2.0))]
    with pytest.raises(UsageError, match="2 compatible starts and goals"):
        imported(tmp_path / "m.scen", Options(robots=3))


def test_smglib_brings_its_walls_in_any_order_of_corners(tmp_path: Path) -> None:
    scenario = imported(file(tmp_path, "doorway.xml", SMG), Options())
    assert scenario.obstacles[0].shape.box == ((3.0, 2.0), (6.0, 3.0))
    assert (scenario.robots[0].radius, scenario.robots[0].goal) == (0.3, (2.0, 1.0))
    assert scenario.workspace.shape.box == ((0.0, 0.0), (8.0, 6.0))


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.yaml", CBS.replace("single_integrator_0", "car_first_order_with_1_trailers_0"), "robots[0].type"),
        ("a.yaml", CBS.replace("type: box", "type: octomap"), "environment.obstacles[0].type"),
        ("a.yaml", CBS.replace("[1.0, 2.0]", "[1.0, -2.0]"), "size"),
        ("a.yaml", CBS.replace("[2.5, 1.0]", "[.nan, 1.0]"), "obstacles[0]"),
        ("a.yaml", "a: 1", "environment"),
        ("a.yaml", CBS.replace("[4.5, 0.5]", "[2.5, 0.5]"), "overlaps the goal of robot 1"),
        ("m.json", "[1", "not JSON"),
        ("m.json", json.dumps(LSC).replace('"type": "crazyflie"', '"type": "drone"'), "agents[0].type"),
        ("m.scen", SCEN, "m.map: 1 problem\n  cannot be read"),
        ("m.scen", "0 m.map 5 3 0 0 4 2 6", "line 1"),
        ("m.scen", "version 1\n0 m.map 5", "nine columns"),
        ("doorway.xml", SMG[:-9], "not XML"),
        ("doorway.xml", SMG.replace('size="0.3"', 'size="big"'), "default_parameters.size"),
        ("doorway.xml", SMG.replace("0 0 0", "0 1 0"), "blocked cells"),
        ("a.txt", "", "unknown suffix"),
    ],
)
def test_what_is_wrong_is_named_with_file_and_place(tmp_path: Path, name: str, text: str, said: str) -> None:
    with pytest.raises((DocumentError, UsageError)) as caught:
        imported(file(tmp_path, name, text), Options())
    assert said in str(caught.value)
    assert name.partition(".")[0] in str(caught.value)
