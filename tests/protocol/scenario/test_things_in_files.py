"""Workspaces and things in scenario files: what is accepted, and every refusal with its path."""

from __future__ import annotations

import pytest

from protocol.errors import ScenarioError
from protocol.geometry import ConvexPolygon, Disk
from protocol.scenario.file import json_schema, parse_toml, write_toml

ROBOT = "[[robots]]\nid = 1\nradius = 0.04\nstart = [-0.2, 0.0]\ngoal = [0.2, 0.0]\n"
SQUARE = "[workspace]\npoints = [[-1, -1], [1, -1], [1, 1], [-1, 1]]\n"


def test_a_polygon_and_things_are_read_and_written_back():
    disk = "[[things]]\ncenter = [0.0, 0.5]\nradius = 0.1\n"
    text = SQUARE + disk + "[[things]]\npoints = [[0, 0.1], [0, 0.3], [0.1, 0.1]]\n"
    scenario = parse_toml(text + ROBOT)
    assert scenario.workspace.shape == ConvexPolygon([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    assert scenario.shapes == {1: Disk(0.0, 0.5, 0.1), 2: ConvexPolygon([(0, 0.1), (0, 0.3), (0.1, 0.1)])}
    assert parse_toml(write_toml(scenario)) == scenario


def test_a_workspace_is_round_unless_points_are_given():
    assert parse_toml(ROBOT).workspace.shape == Disk(0.0, 0.0, 0.3)
    assert {"radius", "points"} <= json_schema()["$defs"]["Workspace"]["properties"].keys()


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (SQUARE + "radius = 1.0\n", "workspace: is given by `radius` or by `points`, not by both"),
        ("[workspace]\npoints = [[-1, -1], [1, 1], [1, -1], [-1, 1]]\n", "workspace.points: crosses itself"),
        (
            "[workspace]\npoints = [[-1, -1], [1, -1], [0.1, 0], [1, 1], [-1, 1]]\n",
            "workspace.points: is not convex",
        ),
        (
            "[workspace]\npoints = [[0, -1], [1, -1], [1, 1], [0, 1]]\n",
            "robots[0].start: reaches 0.24 m out of",
        ),
        ("[[things]]\nradius = 0.1\n", "things[0]: must be a disk, with `center` and `radius`, or"),
        (
            "[[things]]\ncenter = [0.2, 0.05]\nradius = 0.02\n",
            "things[0].center: overlaps the goal of robot 1 by",
        ),
        (
            "[[things]]\npoints = [[-0.3, 0], [0, 0.1], [0, -0.1]]\n",
            "things[0].points: overlaps the start of robot 1",
        ),
        ("[[things]]\ncenter = [3, 0]\nradius = 0.1\n", "things[0].center: lies outside of the workspace"),
        ("[[things]]\npoints = [[0, 0], [0.1, 0]]\n", "things[0].points: needs three points at least"),
        (
            "[[things]]\ncentre = [0, 0]\nradius = 0.1\n",
            "things[0].centre: unknown key; did you mean `center`?",
        ),
    ],
)
def test_a_refusal_names_the_place_and_the_reason(text, problem):
    with pytest.raises(ScenarioError) as refused:
        parse_toml(text + ROBOT)
    assert problem in str(refused.value)
