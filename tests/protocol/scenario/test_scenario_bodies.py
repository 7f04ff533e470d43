"""Bodies, and external bases, in scenario files."""

import pytest

from protocol.scenario.body import PRESETS, Base, Body
from protocol.scenario.file import document_of, parse_document, parse_toml, write_toml
from tests.protocol.scenario.scenario_texts import problems

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


PAIR = """
body = "turtlebot3-burger"
[workspace]
radius = 1.5
[world]
plant = "external"
{base}
[[robots]]
id = 1
start = [-0.8, 0.0]
goal = [0.8, 0.0]
[[robots]]
id = 2
start = [0.8, 0.0]
goal = [-0.8, 0.0]
{two}
"""


def pair(base="", two=""):
    return parse_toml(PAIR.format(base=base, two=two))


def test_each_robot_has_its_own_base_or_the_one_for_all():
    scenario = pair(base="[base]\nstamped = true", two='base = {namespace = "left", timeout = 0.4}')
    assert scenario.base_of(1) == Base(stamped=True)
    assert scenario.base_of(2) == Base(namespace="left", timeout=0.4)
    assert scenario.base_of(1).of(1).topic("cmd_vel") == "bot1/cmd_vel"
    assert scenario.base_of(2).of(2).topic("/odom") == "left/odom"
    assert parse_document(document_of(scenario)) == scenario


def test_the_id_stands_in_every_name():
    base = pair(base='[base]\nnamespace = ""\npose = "vicon/r{id}/pose"\nbase_frame = "r{id}/base"\n'
                'velocity = "r{id}/v"\nodometry = "r{id}/o"').base_of(2)  # fmt: skip
    assert base.of(2).topic(base.of(2).pose) == "vicon/r2/pose"
    assert base.of(2).base_frame == "r2/base"


def test_a_fleet_outside_has_bases_without_being_told_and_bodies_with_everything_that_comes_late():
    body, base = pair().body_of(1), Base()
    assert pair().base_of(1) == base
    assert body.hold == pytest.approx(base.timeout + base.patience + base.latency)
    assert base.lateness.age == pytest.approx(base.age + 2 * base.latency - base.delay)
