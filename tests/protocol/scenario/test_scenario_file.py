"""Scenario files: what is accepted and written back, forms that mean the same, and the schema."""

from dataclasses import fields
from typing import Any

import pytest

from protocol.errors import ScenarioError
from protocol.geometry import ConvexPolygon, Disk
from protocol.scenario.body import Actuation, Base
from protocol.scenario.file import json_schema, parse_document, parse_toml, read_document, write_toml
from protocol.scenario.model import (
    Carrying,
    Control,
    Journey,
    Obstacle,
    Order,
    Part,
    ProcessFault,
    RobotSpec,
    Scenario,
    Sensing,
    Time,
    Workspace,
    World,
)
from protocol.scenario.network import WIRELESS, Burst, Link, Network
from tests.protocol.scenario.scenario_texts import ROBOTS, document, problems


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = \n", "line 1"),
        ("x = 1\nx = 2\ny = 3", "line 2"),
        ("[a]\nb = [1, 2\n", "not TOML"),
        ("a = " + "[" * 100_000, "not TOML"),
        ("a = " + "9" * 5000, "not TOML"),
    ],
)
def test_what_is_not_toml(text: str, words: str) -> None:
    assert words in problems(text)[""]


def test_files_that_cannot_be_read(tmp_path: Any) -> None:
    with pytest.raises(ScenarioError, match="No such file"):
        read_document(tmp_path / "none.toml")
    with pytest.raises(ScenarioError, match="cannot be read"):
        read_document(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ScenarioError, match="not UTF-8"):
        read_document(binary)
    good = tmp_path / "good.toml"
    good.write_bytes(b"\xef\xbb\xbf" + ROBOTS.replace("\n", "\r\n").encode())
    assert parse_document(read_document(good)).ids == (1, 2)


def test_sensing_as_one_table_and_as_an_array() -> None:
    one = parse_toml("[sensing]\nnoise = 0.1" + ROBOTS)
    assert one.sensing == parse_toml("[[sensing]]\nnoise = 0.1" + ROBOTS).sensing == (Sensing(noise=0.1),)
    assert parse_toml(ROBOTS).sensing == (Sensing(),)


def test_schema_knows_every_table_and_both_forms_of_sensing() -> None:
    schema = json_schema()
    assert schema["required"] == ["robots"]
    assert {"from", "until", "groups"} == schema["$defs"]["Partition"]["properties"].keys()
    assert len(schema["properties"]["sensing"]["anyOf"]) == 2


ROBOT = "[[robots]]\nid = 1\nradius = 0.04\nstart = [-0.2, 0.0]\ngoal = [0.2, 0.0]\n"
DISK = "place = { center = [0.0, 0.1], radius = 0.02 }"
GUEST = "add = { id = 2, radius = 0.03, start = [0.0, 0.1], goal = [0.0, -0.1] }"


def orders(*asked: str) -> str:
    return ROBOT + "".join(f"[[orders]]\nat = {at}.5\n{text}\n" for at, text in enumerate(asked))


def test_every_order_is_read_and_written_back() -> None:
    leave = ("remove = 2", "take = 1", "halt = true", "halt = false")
    scenario = parse_toml(
        orders("goal = { robot = 2, points = [[0.1, 0.1]], queue = true }", GUEST, DISK, *leave)
    )
    assert scenario.orders[0].goal == Journey(2, ((0.1, 0.1),), queue=True)
    assert scenario.newcomers == (RobotSpec(2, 0.03, (0.0, 0.1), (0.0, -0.1)),)
    assert scenario.orders[2].place == Obstacle(center=(0.0, 0.1), radius=0.02)
    assert [order.halt for order in scenario.orders[-2:]] == [True, False]
    assert [order.at for order in scenario.orders] == [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5]
    assert parse_toml(write_toml(scenario)) == scenario


def test_a_guest_without_a_radius_has_that_of_its_body() -> None:
    text = 'body = "e-puck"\n' + orders(GUEST.replace("radius = 0.03, ", "")).replace("0.04", "0.06")
    scenario = parse_toml(text + '[[process]]\nrobot = 2\nat = 3.0\nevent = "kill"\n')  # faults may name it
    assert scenario.newcomers[0].radius == pytest.approx(0.055)


SQUARE = "[workspace]\npoints = [[-1, -1], [1, -1], [1, 1], [-1, 1]]\n"


def test_a_polygon_and_obstacles_are_read_and_written_back():
    disk = "[[obstacles]]\ncenter = [0.0, 0.5]\nradius = 0.1\n"
    assert parse_toml(ROBOT).workspace.shape == Disk(0.0, 0.0, 0.3)  # unless anything is given
    text = SQUARE + disk + "[[obstacles]]\npoints = [[0, 0.1], [0, 0.3], [0.1, 0.1]]\n"
    scenario = parse_toml(text + ROBOT)
    assert scenario.workspace.shape == ConvexPolygon([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    assert scenario.shapes == {1: Disk(0.0, 0.5, 0.1), 2: ConvexPolygon([(0, 0.1), (0, 0.3), (0.1, 0.1)])}
    assert parse_toml(write_toml(scenario)) == scenario


@pytest.mark.parametrize("preset", WIRELESS)
def test_what_is_given_outranks_a_preset(preset: str) -> None:
    plain = parse_document(document() | {"link": {"preset": preset}}).link
    for key, value in WIRELESS[preset].items():
        assert getattr(plain, key) == value
    given = {"preset": preset, "delay": 0.3, "burst": {"loss": 0.5}, "loss": 0.1}
    link = parse_document(document() | {"link": given}).link
    assert (link.delay, link.burst, link.loss) == (0.3, Burst(loss=0.5), 0.1)
    assert link.roaming == plain.roaming


def test_every_field_is_written() -> None:
    said: dict[str, Any] = {
        "name": "all",
        "description": "of them",
        "seed": 3,
        "workspace": Workspace(0.4),
        "time": Time(limit=9.0),
        "control": Control(k=7.0),
        "sensing": (Sensing(dropout=0.5),),
        "link": Link(loss=0.5),
        "network": Network("near", 0.2),
        "process": (ProcessFault(1, 1.0, "restart"),),
        "actuation": Actuation(0.1),
        "world": World("mujoco"),
        "base": Base(patience=0.05),
        "body": "e-puck",
        "obstacles": (Obstacle(center=(0.0, 0.2), radius=0.01),),
        "parts": (Part(0.01, (0.0, -0.2), (0.0, -0.3)),),
        "carrying": Carrying(0.02),
        "orders": (Order(1.0, halt=True),),
        "robots": (RobotSpec(1, 0.06, (0.0, 0.0), (0.1, 0.0)),),
    }
    assert said.keys() | {"map"} == {field.name for field in fields(Scenario)}  # it stands for `obstacles`
    plain: dict[str, Any] = {"world": World(), "body": "point", "base": None, "network": Network()}
    for otherwise in ({"parts": ()}, plain):  # not everything goes together with parts
        scenario = Scenario(**(said | otherwise))
        assert parse_toml(write_toml(scenario)) == scenario
