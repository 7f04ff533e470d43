"""Bases outside in a scenario: what is read, what is derived, and what is refused."""

from __future__ import annotations

import pytest

from protocol.errors import ScenarioError
from protocol.scenario.body import PRESETS, Base
from protocol.scenario.file import document_of, parse_document, parse_toml

PAIR = """
body = "turtlebot3-burger"
[workspace]
radius = 1.5
[world]
plant = "external"
{world}
{base}
[[robots]]
id = 1
start = [-0.8, 0.0]
goal = [0.8, 0.0]
{one}
[[robots]]
id = 2
start = [0.8, 0.0]
goal = [-0.8, 0.0]
{two}
"""


def pair(world="", base="", one="", two=""):
    return parse_toml(PAIR.format(world=world, base=base, one=one, two=two))


def test_each_robot_has_its_own_base_or_the_one_for_all():
    scenario = pair(base="[base]\nstamped = true", two='base = {namespace = "left", timeout = 0.4}')
    assert scenario.base_of(1) == Base(stamped=True)
    assert scenario.base_of(2) == Base(namespace="left", timeout=0.4)
    assert scenario.base_of(1).of(1).key("cmd_vel") == "bot1/cmd_vel"
    assert scenario.base_of(2).of(2).key("/odom") == "left/odom"
    assert parse_document(document_of(scenario)) == scenario


def test_the_id_stands_in_every_name():
    base = pair(base='[base]\nnamespace = ""\npose = "vicon/r{id}/pose"\nbase_frame = "r{id}/base"\n'
                'velocity = "r{id}/v"\nodometry = "r{id}/o"').base_of(2)  # fmt: skip
    assert base.of(2).key(base.of(2).pose) == "vicon/r2/pose"
    assert base.of(2).base_frame == "r2/base"


@pytest.mark.parametrize("namespace", ["", "/"])
def test_a_single_robot_needs_no_namespace(namespace):
    assert Base(namespace=namespace).of(1).key("/odom") == "odom"


def test_a_fleet_outside_has_bases_without_being_told():
    assert pair().base_of(1) == Base()
    assert not pair(world="lease = 2.0").spec(1).base


def test_the_filter_takes_a_body_with_everything_that_comes_late():
    body, base = pair().body_of(1), Base()
    assert body.hold == pytest.approx(base.timeout + base.patience + base.latency)
    assert body.lag == pytest.approx(PRESETS["turtlebot3-burger"].lag + base.age + 2 * base.latency)


@pytest.mark.parametrize(
    ("texts", "wrong"),
    [
        ({"one": 'body = "point"'}, r"robots\[0\]\.body: a base outside cannot stop at once"),
        (
            {"base": '[base]\nnamespace = "/bot"'},
            r"robots\[1\]\.base: has the same key bot/cmd_vel as robots\[0\]",
        ),
        (
            {"one": 'base = {odometry = "odom/**"}'},
            r"robots\[0\]\.base\.odometry: 'odom/\*\*' is no ROS name",
        ),
        ({"one": 'base = {pose = "a//b"}'}, r"robots\[0\]\.base\.pose: 'a//b' is no ROS name"),
        ({"one": 'base = {pose = "/"}'}, r"robots\[0\]\.base\.pose: must not be empty"),
        ({"two": 'base = {pose = "odom"}'}, r"robots\[1\]\.base: `odometry` and `pose` are both bot2/odom"),
        ({"two": 'base = {velocity = "a", odometry = "/a/"}'}, "`velocity` and `odometry` are both bot2/a"),
        ({"two": 'base = {base_frame = "a\\nb"}'}, r"robots\[1\]\.base\.base_frame: must have no control"),
        (
            {"one": 'base = {namespace = "bot2"}'},
            r"robots\[1\]\.base: has the same key bot2/cmd_vel as robots\[0\]",
        ),
        ({"base": "[base]\ntimeout = 0"}, r"base\.timeout: must be at least"),
        ({"base": "[base]\ntopic = 1"}, r"base\.topic: unknown key"),
        ({"world": "lease = 0.1"}, r"world\.lease: must be at least 3 ticks"),
        ({"two": '[[process]]\nrobot = 1\nat = 1.0\nevent = "kill"'}, "process: nobody can script"),
    ],
)
def test_what_is_wrong_is_named(texts, wrong):
    with pytest.raises(ScenarioError, match=wrong):
        pair(**texts)
