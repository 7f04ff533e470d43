"""Floor plans: maps of map_server, the obstacles that stand for them, and scenarios that name them."""

import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from scipy import ndimage
from typer.testing import CliRunner

from deploy import library
from deploy.cli.scenario import app
from deploy.library.load import MAPS, build, load, read
from deploy.maps.occupancy import MOST_CELLS, Mask, Occupancy, read_map
from deploy.maps.pieces import floor_plan
from deploy.theory.surrounded import surrounded
from disknav import Simulation
from protocol.errors import DocumentError, MapError, ScenarioError
from protocol.geometry import ConvexPolygon, defect
from protocol.scenario.file import parse_toml, write_toml

HEAD = """image: m.png
resolution: 0.1
origin: [0.0, 0.0, 0.0]
occupied_thresh: 0.65
free_thresh: 0.25
negate: 0
"""


def drawn(folder: Path, rows: list[str], head: str = HEAD, suffix: str = "png") -> Path:
    """A map, northernmost row first: # occupied, . free, ? unknown."""
    grey = {"#": 0, ".": 254, "?": 150}
    picture = np.array([[grey[cell] for cell in row] for row in rows], dtype=np.uint8)
    Image.fromarray(picture).save(folder / f"m.{suffix}")
    path = folder / "m.yaml"
    path.write_text(head.replace("m.png", f"m.{suffix}"))
    return path


ROOM = ["##########", "#...#....#", "#........#", "#...#....#", "#...#....#", "#####?####"]


@pytest.mark.parametrize("suffix", ["png", "pgm"])
def test_a_map_is_read_from_south_to_north(tmp_path: Path, suffix: str) -> None:
    grid = read_map(drawn(tmp_path, ROOM, suffix=suffix))
    assert grid.occupied.shape == (6, 10)
    assert grid.unknown[0, 5]
    assert not grid.occupied[0, 5]
    assert grid.occupied[1, 4]
    assert not grid.occupied[3, 4]
    assert grid.cell(0.45, 0.15) == (1, 4)
    assert grid.cell(-0.01, 0.1) is None


def test_negated_and_raw_pictures_give_the_same_map(tmp_path: Path) -> None:
    usual = read_map(drawn(tmp_path, ROOM))
    grey = np.asarray(Image.open(tmp_path / "m.png"))
    raw = np.where(grey == 0, 100, np.where(grey == 254, 0, 255)).astype(np.uint8)
    for head, picture in ((HEAD.replace("negate: 0", "negate: 1"), 255 - grey), (HEAD + "mode: raw\n", raw)):
        path = drawn(tmp_path, ROOM, head)
        Image.fromarray(picture).save(tmp_path / "m.png")
        assert (read_map(path).occupied == usual.occupied).all()
        assert (read_map(path).unknown == usual.unknown).all()


@pytest.mark.parametrize(
    ("free_thresh", "grey", "free"), [(0.25, 205, True), (0.196, 205, False), (0.25, 220, False)]
)
def test_a_threshold_that_frees_the_unknown_of_map_savers_is_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, free_thresh: float, grey: int, free: bool
) -> None:
    path = drawn(tmp_path, ["..##"], HEAD.replace("0.25", str(free_thresh)))
    Image.fromarray(np.array([[254, grey, 0, 0]], dtype=np.uint8)).save(tmp_path / "m.png")
    assert read_map(path).unknown[0, 1] == (grey == 205 and not free)
    assert ("0.196 keeps it unknown" in caplog.text) == free


def test_transparent_pixels_are_unknown_and_deep_ones_are_refused(tmp_path: Path) -> None:
    """Beyond 8 bits all but the darkest pixels would count as white, and so as free."""
    path = drawn(tmp_path, ["..##"])
    grey = np.array([[254, 254, 0, 5]], dtype=np.uint8)
    Image.fromarray(np.stack([grey, np.array([[255, 254, 0, 255]], np.uint8)], -1)).save(tmp_path / "m.png")
    grid = read_map(path)
    assert grid.unknown.tolist() == [[False, True, False, False]]
    assert grid.occupied.tolist() == [[False, False, True, True]]
    for suffix in ("png", "pgm"):
        Image.fromarray(grey.astype(np.uint16) * 257).save(tmp_path / f"m.{suffix}")
        path.write_text(HEAD.replace("m.png", f"m.{suffix}"))
        with pytest.raises(MapError, match="more than 8 bits"):
            read_map(path)


def test_the_origin_places_and_turns_the_map(tmp_path: Path) -> None:
    head = HEAD.replace("[0.0, 0.0, 0.0]", f"[1.0, -2.0, {math.pi / 2}]")
    grid = read_map(drawn(tmp_path, ROOM, head))
    assert grid.place(4.0, 1.0) == pytest.approx((1.0 - 0.1, -2.0 + 0.4))
    assert grid.cell(1.0 - 0.15, -2.0 + 0.45) == (1, 4)


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 3.0), st.floats(0.2, 0.9), st.booleans(), st.booleans())
@settings(max_examples=8, deadline=None)
def test_pieces_cover_what_is_solid_and_reach_no_farther_than_the_error(
    seed: int, error: float, share: float, blobs: bool, rim: bool
) -> None:
    random = np.random.default_rng(seed)
    field = random.random((16, 21))
    field = ndimage.gaussian_filter(field, 2.0) if blobs else field
    solid: Mask = field < np.quantile(field, share)
    plan = floor_plan(Occupancy(solid, np.zeros_like(solid), 1.0), error, rim=rim)
    assert (plan.free == ~solid).all()
    around = np.pad(solid, 1, constant_values=True)  # beyond the map nothing is free
    assert not [piece for piece in plan.obstacles if defect(piece)]
    shapes, room = [ConvexPolygon(piece) for piece in plan.obstacles], ConvexPolygon(plan.workspace)
    for row, column in (np.argwhere(around) - 1).tolist():
        inside = room.distance(column + 0.5, row + 0.5)
        if inside < (1.0 if rim else 0.0):  # each solid cell, whole
            corners = [(column + x, row + y) for x in (0, 1) for y in (0, 1)]
            assert any(all(shape.distance(*corner) < 1e-9 for corner in corners) for shape in shapes)
    cells = np.argwhere(around) - 0.5
    for shape in shapes:
        for x, y in random.uniform(*shape.box, (40, 2)).tolist():
            if shape.distance(x, y) < 0.0:
                beyond = np.maximum(np.abs(np.array([y, x]) - cells) - 0.5, 0.0)
                assert np.hypot(*beyond.T).min() <= error + 1e-9


def test_free_space_that_no_robot_fits_into_is_left_out(tmp_path: Path) -> None:
    grid = read_map(drawn(tmp_path, ["#######", "#.#...#", "###...#", "###...#", "#######"]))
    plan = floor_plan(grid, 0.0, 0.12)
    assert plan.free.sum() == 9
    assert ConvexPolygon(plan.workspace).box == (pytest.approx((0.3, 0.1)), pytest.approx((0.6, 0.4)))
    assert plan.obstacles == []
    assert not floor_plan(grid, 0.0, 0.3).free.any()


def test_the_unknown_is_an_obstacle_unless_the_scenario_says_otherwise(tmp_path: Path) -> None:
    grid = read_map(drawn(tmp_path, ["....", ".??.", "...."]))
    (piece,) = floor_plan(grid, 0.0).obstacles
    assert ConvexPolygon(piece).box == ((0.1, 0.1), pytest.approx((0.3, 0.2)))
    assert floor_plan(grid, 0.0, unknown_is_free=True).obstacles == []


# -- bad input: the file, the place, and what is wrong


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("0.1", ".nan"), "resolution"),
        (("0.1", "-0.1"), "resolution"),
        (("0.1", "1e+9"), "resolution"),
        (("0.1", "wide"), "resolution"),
        (("[0.0, 0.0, 0.0]", "[0.0, .inf, 0.0]"), "origin"),
        (("[0.0, 0.0, 0.0]", "[0.0, 0.0]"), "origin"),
        (("free_thresh: 0.25", "free_thresh: 0.9"), "free_thresh"),
        (("image: m.png\n", ""), "image"),
        (("image: m.png", "image: none.png"), "none.png"),
        (("image", "image: ["), "not YAML"),
        ((HEAD, "\x00\xff"), "not YAML"),
        ((HEAD, "just a word"), "bject"),
    ],
)
def test_a_bad_yaml_file_is_named_with_the_place(tmp_path: Path, change: tuple[str, str], said: str) -> None:
    path = drawn(tmp_path, ROOM)
    path.write_text(HEAD.replace(*change))
    with pytest.raises(MapError) as caught:
        read_map(path)
    assert said in str(caught.value)
    assert str(tmp_path) in str(caught.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"P5 20000 20000 255\n", f"too many pixels, at most {MOST_CELLS:,}"),
        (b"P5 5000 4000 255\n", f"has 5000 x 4000 pixels, at most {MOST_CELLS:,}"),
        (b"P5 4 -4 255\n", "not a complete"),
        (b"P5 40 40 255\n1234", "not a complete"),
        (b"GIF89a", "not a complete"),
        (b"", "not a complete"),
    ],
)
def test_a_bad_picture_is_named(tmp_path: Path, content: bytes, said: str) -> None:
    path = drawn(tmp_path, ROOM)
    (tmp_path / "m.png").write_bytes(content)
    with pytest.raises(MapError, match=r"m\.png") as caught:
        read_map(path)
    assert said in str(caught.value)


# -- scenarios on maps

ON_MAP = """
map = { file = "m.yaml", error = 0.0 }
robots = [{ id = 1, radius = 0.06, start = [0.25, 0.25], goal = %s }]
"""


def written(folder: Path, goal: str, rows: list[str] = ROOM) -> str:
    drawn(folder, rows)
    (folder / "s.toml").write_text(ON_MAP % goal)
    return str(folder / "s.toml")


def test_a_scenario_names_its_map_beside_it(tmp_path: Path) -> None:
    scenario = load(written(tmp_path, "[0.7, 0.25]"))
    assert scenario.map is None
    assert len(scenario.obstacles) == 2
    assert scenario.workspace.shape.box == (pytest.approx((0.1, 0.1)), pytest.approx((0.9, 0.5)))
    assert parse_toml(write_toml(scenario)) == scenario  # what is shown is complete


def test_walls_are_obstacles_in_a_workspace_beyond_them(tmp_path: Path) -> None:
    workspace = "workspace.points=[[-1.0, -1.0], [2.0, -1.0], [2.0, 2.0], [-1.0, 2.0]]"
    scenario = load(written(tmp_path, "[0.7, 0.25]"), [workspace])
    assert scenario.workspace.shape.box == ((-1.0, -1.0), (2.0, 2.0))
    for x, y in ((0.05, 0.3), (0.95, 0.3), (0.5, 0.05), (0.5, 0.55)):
        assert min(shape.distance(x, y) for shape in scenario.shapes.values()) <= 0.0


def test_the_part_of_a_map_outside_of_the_workspace_is_ignored(tmp_path: Path) -> None:
    half = "workspace.points=[[0.0, 0.0], [0.39, 0.0], [0.39, 0.6], [0.0, 0.6]]"
    scenario = load(written(tmp_path, "[0.2, 0.4]"), [half])
    assert scenario.obstacles
    assert all(shape.box[0][0] < 0.39 for shape in scenario.shapes.values())


def test_a_place_deep_inside_a_wall_is_one_of_an_obstacle(tmp_path: Path) -> None:
    rows = ["." * 30, *["." * 5 + "#" * 20 + "." * 5] * 20, "." * 30]
    path = written(tmp_path, "[0.05, 0.05]", rows)
    scenario = load(path, ["robots[0].start=[0.05, 0.05]", "robots[0].radius=0.04"])
    assert min(shape.distance(1.5, 1.1) for shape in scenario.shapes.values()) <= -0.5


@pytest.mark.parametrize(
    ("goal", "path", "said"),
    [
        ("[0.45, 0.15]", "robots[0].goal", "column 4, row 1 from below"),
        ("[5.0, 0.15]", "robots[0].goal", "outside of it"),
        ("[0.53, 0.25]", "map (obstacle", "overlaps the goal of robot 1"),
    ],
)
def test_places_that_are_not_free_are_named(tmp_path: Path, goal: str, path: str, said: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        read(written(tmp_path, goal))
    (problem,) = caught.value.problems
    assert problem.path.startswith(path)
    assert said in problem.text


@pytest.mark.parametrize(
    "setting", ["map.error=-1", "map.error=nan", "map.unknown=dark", "map.file=''", "map.fil=x"]
)
def test_bad_settings_of_a_map_are_refused(tmp_path: Path, setting: str) -> None:
    with pytest.raises(DocumentError, match=r"map\."):
        read(written(tmp_path, "[0.7, 0.25]"), [setting])


def test_check_says_whose_goal_is_barred_and_where(tmp_path: Path) -> None:
    path = written(tmp_path, "[0.7, 0.25]")
    report = surrounded(load(path))
    assert (report.no_way, report.doors) == ((), ())
    (found,) = report.unreachable
    assert (found.robot, found.x, found.y) == (1, pytest.approx(0.45, abs=0.06), pytest.approx(0.35))
    assert found.width == pytest.approx(0.1)
    assert not surrounded(load(path, ["robots[0].radius=0.04"])).unreachable


def test_import_writes_a_scenario_that_names_the_map(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    path, out = drawn(tmp_path, ["." * 30] * 30), tmp_path / "out" / "s.toml"
    given = ["--robots", "3", "--radius", "0.1", "--error", "0.2", "-o", str(out)]
    done = CliRunner().invoke(app, ["import", str(path), *given])
    assert done.exit_code == 0, done.output
    assert 'file = "../m.yaml"' in out.read_text()
    assert "error = 0.2" in out.read_text()
    assert len(load(str(out)).robots) == 3


@pytest.mark.parametrize("name", MAPS)
def test_maps_of_the_library_are_read_without_a_warning(
    tmp_path: Path, name: str, caplog: pytest.LogCaptureFixture
) -> None:
    folder = shutil.copytree(Path(library.__file__).with_name("maps"), tmp_path / "maps")
    read_map(folder / f"{name}.yaml")
    assert not caplog.records


@pytest.mark.slow
@pytest.mark.parametrize("name", MAPS)
def test_goals_on_the_maps_of_the_library_can_be_reached(name: str) -> None:
    report = surrounded(load(f"{name}-6"))
    assert not report.unreachable
    assert not report.no_way
    assert build(f"{name}-6", 1) != build(f"{name}-6", 2)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == "office" else pytest.mark.campaign) for name in MAPS]
)
def test_robots_arrive_on_the_maps_of_the_library(name: str) -> None:
    report = Simulation(load(f"{name}-2")).finish()
    assert report["verdict"] == "arrived"
    assert report["min_clearance"] > 0.0
