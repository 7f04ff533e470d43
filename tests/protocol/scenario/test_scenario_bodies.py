"""Bodies in scenario files: by name or as a table, for all or for one; and what is wrong with them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from protocol.scenario.body import PRESETS, Body
from protocol.scenario.file import document_of, parse_document, parse_toml, write_toml
from tests.protocol.scenario.scenario_texts import ROBOTS, problems

WIDE = "[workspace]\nradius = 3.0\n"
ONE = "[[robots]]\nid = 1\nstart = [0.0, 0.0]\ngoal = [1.0, 0.0]\n"


def test_a_body_of_all_and_one_of_a_robot() -> None:
    scenario = parse_toml(
        'body = "turtlebot4"\n' + WIDE + ONE + "heading = 1.5\n[[robots]]\nid = 2\nstart = [1.0, 1.0]\n"
        'goal = [-1.0, 0.0]\nradius = 0.2\nbody = { kind = "omnidirectional", acceleration = 0.5 }\n'
    )
    assert scenario.body_of(1) == PRESETS["turtlebot4"]
    assert scenario.body_of(2) == Body("omnidirectional", acceleration=0.5)
    assert scenario.spec(1).radius == pytest.approx(0.255)
    assert parse_toml(write_toml(scenario)) == scenario
    assert parse_document(document_of(scenario)) == scenario


def test_a_point_is_what_there_is_without_a_word() -> None:
    scenario = parse_toml(ROBOTS)
    assert all(scenario.body_of(robot).ideal for robot in scenario.ids)
    assert "body" not in document_of(scenario)
    assert not replace(PRESETS["point"], lag=0.001).ideal


def test_every_preset_has_wheels_inside_its_hull_and_brakes() -> None:
    for name, body in PRESETS.items():
        if name != "point":
            assert body.kind == "differential-drive"
            assert 0.0 < body.offset < body.track <= 2.0 * (body.radius or 0.0)
            assert body.acceleration < 10.0


def test_what_is_wrong_is_named() -> None:
    assert "turtlebot3-burger" in problems('body = "roomba"\n' + ROBOTS)["body"]
    assert problems('body = { kind = "differential-drive", track = 0.1 }\n' + ROBOTS) == {
        "body.offset": "must be above 0 for a body on two wheels"
    }
    assert problems('body = "e-puck"\n' + ROBOTS) == {
        f"robots[{n}].radius": "must be at least 0.055, for the body lies inside the disk" for n in (0, 1)
    }
    assert problems('body = { kind = "omnidirectional", brakes = 1.0 }\n' + ROBOTS)["body.brakes"].startswith(
        "unknown key"
    )
    assert problems(ONE)["robots[0].radius"] == "is missing"
    assert list(problems('[world]\nplant = "mujoco"\n' + ROBOTS)) == ["robots[0].body", "robots[1].body"]


def test_mujoco_moves_bodies_only_as_their_errors_were_measured() -> None:
    def written(body: str, step: str) -> str:
        return f'body = {body}\n[world]\nplant = "mujoco"\n[time]\nstep = {step}\n{WIDE}{ONE}radius = 0.2\n'

    burger = '"turtlebot3-burger"'
    wheels = '{ kind = "differential-drive", offset = 0.05, track = 0.16, acceleration = %s }'
    for body, step in ((burger, "0.01"), (burger, "0.033"), (burger, "1.0"), (wheels % "1.5", "0.05")):
        assert parse_toml(written(body, step)).world.plant == "mujoco"
    for step in ("0.009", "1.01"):
        assert problems(written(burger, step))["time.step"].startswith("must be from 0.01 to 1 s")
    for body in (wheels % "1.6", wheels.replace(", acceleration = %s", "")):
        assert "at most 1.5" in problems(written(body, "0.05"))["robots[0].body.acceleration"]
