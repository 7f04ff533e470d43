"""Orders in scenario files: what is accepted, and every refusal with its path."""

from __future__ import annotations

import pytest

from protocol.errors import ScenarioError
from protocol.scenario.file import parse_toml, write_toml
from protocol.scenario.model import Journey, RobotSpec, Thing

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
    assert scenario.orders[2].place == Thing(center=(0.0, 0.1), radius=0.02)
    assert [order.halt for order in scenario.orders[-2:]] == [True, False]
    assert [order.at for order in scenario.orders] == [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5]
    assert parse_toml(write_toml(scenario)) == scenario


def test_a_guest_without_a_radius_has_that_of_its_body() -> None:
    text = 'body = "e-puck"\n' + orders(GUEST.replace("radius = 0.03, ", "")).replace("0.04", "0.06")
    assert parse_toml(text).newcomers[0].radius == pytest.approx(0.055)


def test_faults_may_name_guests() -> None:
    fault = '[[process]]\nrobot = 2\nat = 3.0\nevent = "kill"\n'
    assert parse_toml(orders(GUEST) + fault).process[0].robot == 2


@pytest.mark.parametrize(
    ("asked", "problem"),
    [
        ("", "orders[0]: must ask for one of goal, add, remove, place, take, halt, and asks for none"),
        (
            "remove = 1\nhalt = true",
            "orders[0]: must ask for one of goal, add, remove, place, take, halt, not",
        ),
        ("goal = { robot = 7 }", "orders[0].goal.robot: there is never a robot 7"),
        (
            "goal = { robot = 1, points = [[0.1, 0.5]] }",
            "orders[0].goal.points[0]: reaches 0.21 m out of the",
        ),
        ("goal = { points = [] }", "orders[0].goal.robot: is missing"),
        ("goal = { robot = 1, point = [] }", "orders[0].goal.point: unknown key; did you mean `points`?"),
        ("remove = 2", "orders[0].remove: there is never a robot 2"),
        ("take = 1", "orders[0].take: there is never a thing 1"),
        (
            GUEST.replace("[0.0, 0.1]", "[0.0, 0.28]"),
            "orders[0].add.start: reaches 0.01 m out of the workspace",
        ),
        (GUEST.replace("0.03", "0.3"), "orders[0].add.radius: a disk of radius 0.3 m does not fit"),
        (
            GUEST.replace("id = 2", 'id = 2, body = { kind = "differential-drive" }'),
            "orders[0].add.body.offset",
        ),
        (DISK.replace("0.1", "9.0"), "orders[0].place.center: lies outside of the workspace"),
        ("place = { radius = 0.1 }", "orders[0].place: must be a disk, with `center` and `radius`, or a"),
        ("halt = 1", "orders[0].halt: must be true or false, not 1"),
    ],
)
def test_a_refusal_names_the_place_and_the_reason(asked: str, problem: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        parse_toml(orders(asked))
    assert any(str(each).startswith(problem) for each in refused.value.problems), refused.value
