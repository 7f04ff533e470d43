"""The scene: as Foxglove defines it, whole in every message, at a bounded rate."""

import json
from collections import Counter
from typing import Any

import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms  # type: ignore[import-untyped]
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate  # type: ignore[import-untyped]
from google.protobuf import json_format
from msgspec.structs import replace

from deploy.telemetry.live import FleetView
from deploy.telemetry.scene import FleetScene, Picture
from protocol import messages
from protocol.messages import Clock, GoalStatus, Health, Member, Message, Roster, Standing, Tick, Truth
from protocol.scenario.model import Obstacle, Order, RobotSpec, Scenario

ROBOTS = (RobotSpec(3, 0.03, (-0.1, 0.0), (0.1, 0.0)), RobotSpec(7, 0.02, (0.0, 0.0), (0.0, 0.1)))
THINGS = (
    Obstacle(center=(0.0, -0.2), radius=0.02),
    Obstacle(points=((0.1, -0.2), (0.2, -0.2), (0.15, -0.1))),
)
SCENARIO = Scenario(ROBOTS, name="two", obstacles=THINGS)


class ViewedScene(FleetScene):
    """A scene of a view of its own."""

    def __init__(self, scenario: Scenario) -> None:
        self.view = FleetView("r")
        self.view.begin(scenario, True)
        super().__init__(self.view)

    def hear(self, message: Message) -> list[Picture]:
        self.view.on_message(message, 0.0)
        return self.after(message)


def truth(tick: int, x: float = 0.0) -> Truth:
    return Truth(tick, (3, 7), ((x, 0.0), (0.05, 0.01)), 0.01, 0.5)


def health(robot: int, peer: int) -> Health:
    return Health(robot, 1, 1, 0.001, 1, 1, {}, (), ((peer, 1.0, 0.0, 0.03),))


def content(picture: Picture) -> dict[str, Any]:
    return dict(json.loads(picture.data))


def drawn(scene: ViewedScene, topic: str) -> list[dict[str, Any]]:
    return list(content(scene.picture(topic))["entities"])


def untimed(value: Any) -> Any:
    """Without times: in JSON they are two numbers, in protobuf's own JSON a text."""
    if isinstance(value, dict):
        return {name: untimed(each) for name, each in value.items() if name not in ("timestamp", "lifetime")}
    return [untimed(each) for each in value] if isinstance(value, list) else value


def test_every_update_is_one_by_foxgloves_own_definition() -> None:
    scene = ViewedScene(SCENARIO)
    for message in (truth(1), truth(4, 0.01), health(3, 7), health(7, 3)):
        scene.hear(message)
    updates = [picture for picture in scene.whole() if picture.topic.startswith("/scene/")]
    assert len(updates) == 5
    for picture in updates:
        update = json_format.ParseDict(untimed(content(picture)), SceneUpdate())  # strict
        assert any(each.cylinders or each.lines for each in update.entities), picture.topic


def test_goals_move_with_orders_and_robots_that_are_down_turn_red() -> None:
    scene = ViewedScene(SCENARIO)
    (goals,) = scene.hear(GoalStatus(7, 4, 1, "under way", (-0.1, 0.2)))
    (entity,) = content(goals)["entities"]
    assert [each["pose"]["position"]["x"] for each in entity["cylinders"]] == [0.1, -0.1]
    before = [each["cylinders"][0]["color"] for each in drawn(scene, "/scene/robots")]
    (robots,) = scene.hear(Clock(4, 0.2, (3,), (Standing(7, 1, (0.0, 0.0)),), ""))
    after = [each["cylinders"][0]["color"] for each in content(robots)["entities"]]
    assert (after[0], after[1] != before[1]) == (before[0], True)
    assert not scene.hear(Clock(5, 0.25, (3,), (Standing(7, 1, (0.0, 0.0)),), ""))


def test_obstacles_that_come_or_go_change_the_room() -> None:
    scene = ViewedScene(SCENARIO)
    came = messages.PlacedObstacle(3, "standing", ((0.2, 0.1),), 0.01)
    clock = Clock(1, 0.05, (3, 7), (), "", obstacles=(came, messages.PlacedObstacle(1, "gone")))
    (room,) = scene.hear(clock)
    (entity,) = content(room)["entities"]
    corners = [len(each["points"]) for each in entity["triangles"]]
    assert corners == [3, 3 * 46]  # obstacle 2, and 3 of 48 corners
    assert not scene.hear(replace(clock, tick=2, time=0.1))


def test_lines_are_drawn_between_near_robots() -> None:
    scene = ViewedScene(SCENARIO)
    scene.hear(health(3, 7))
    scene.hear(truth(1, 0.0))
    (near,) = drawn(scene, "/scene/lines")
    assert [point["x"] for point in near["lines"][0]["points"]] == pytest.approx([0.03, 0.03])
    scene.hear(truth(2, -0.2))
    (far,) = drawn(scene, "/scene/lines")
    assert far["lines"] == []


def test_pictures_come_at_a_bounded_rate() -> None:
    scene = ViewedScene(SCENARIO)
    counts = Counter(picture.topic for tick in range(1, 201) for picture in scene.hear(truth(tick)))
    assert counts == {"/tf": 100, "/measures": 100, "/scene/lines": 10, "/scene/trails": 5}


def drawn_robots(scene: ViewedScene) -> list[str]:
    return [entity["id"] for entity in drawn(scene, "/scene/robots")]


def frames(scene: ViewedScene) -> dict[str, float]:
    read = json_format.ParseDict(untimed(content(scene.picture("/tf"))), FrameTransforms())  # strict
    return {each.child_frame_id: each.translation.x for each in read.transforms}


def test_robots_that_orders_add_are_drawn_while_they_are_there() -> None:
    far, near = RobotSpec(5, 0.01, (-0.2, 0.0), (0.2, 0.2)), RobotSpec(5, 0.04, (0.2, 0.0), (0.2, -0.2))
    orders = (Order(0.0, add=far), Order(0.1, add=near))
    scene = ViewedScene(Scenario(ROBOTS, orders=orders))
    scene.hear(truth(1))
    three = Truth(2, (3, 5, 7), ((0.1, 0.0), (0.2, 0.01), (0.3, 0.0)), 0.01, 0.5)
    changed = [picture.topic for picture in scene.hear(three)]
    assert {"/tf", "/scene/robots", "/scene/goals"} <= {*changed}
    assert drawn_robots(scene) == ["robot 3", "robot 5", "robot 7"]
    assert frames(scene) == {"robot_3": 0.1, "robot_5": 0.2, "robot_7": 0.3}
    (goals,) = drawn(scene, "/scene/goals")
    assert [each["size"]["x"] for each in goals["cylinders"]] == [0.06, 0.08, 0.04]  # the one that began near
    scene.hear(health(7, 3))
    scene.hear(Truth(10, (3, 5), ((0.1, 0.0), (0.0, 0.1)), 0.01, 0.5))
    (robots,) = scene.latest("/scene/robots")
    (deletion,) = content(robots)["deletions"]
    assert deletion == {"timestamp": {"sec": 0, "nsec": 500_000_000}, "type": 1, "id": ""}
    assert drawn_robots(scene) == ["robot 3", "robot 5"]
    assert frames(scene) == {"robot_3": 0.1, "robot_5": 0.0}
    for topic, pieces in (("/scene/lines", 0), ("/scene/trails", 2)):
        (entity,) = drawn(scene, topic)
        assert len(entity["lines"]) == pieces, topic


def test_a_robot_that_an_operator_adds_is_drawn_as_large_as_the_roster_says() -> None:
    scene = ViewedScene(SCENARIO)
    there = Truth(1, (3, 7, 9), ((0.0, 0.0), (0.05, 0.01), (0.3, 0.3)), 0.01, 0.5)
    scene.hear(there)
    assert drawn_robots(scene) == ["robot 3", "robot 7"]
    member = Member(9, 0, "appearing", 0.05, (0.3, 0.3))
    scene.hear(Tick(3, 1, 0, (), roster=Roster(2, (member,))))
    scene.hear(replace(there, tick=2))
    assert drawn(scene, "/scene/robots")[-1]["cylinders"][0]["size"]["x"] == 0.1
    assert len(drawn(scene, "/scene/goals")[0]["cylinders"]) == 2  # its goal is unknown
    scene.hear(GoalStatus(9, 2, 1, "under way", (-0.1, 0.2)))
    assert len(drawn(scene, "/scene/goals")[0]["cylinders"]) == 3


def test_strangers_and_unknown_times_change_nothing() -> None:
    scene = ViewedScene(SCENARIO)
    scene.hear(truth(0))
    before = [*scene.whole()]
    assert not scene.hear(truth(2**53))
    scene.hear(Truth(0, (3, 7, 9), ((0.0, 0.0), (0.05, 0.01), (0.3, 0.3)), 0.01, 0.5))
    scene.hear(health(9, 3))
    scene.hear(GoalStatus(9, 1, 1, "under way", (0.0, 0.0)))
    assert [*scene.whole()] == before
