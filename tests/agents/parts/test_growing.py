"""A robot that grows is clear of everything but the one part that it asks for."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from agents.robot import Robot
from protocol.messages import Handling
from protocol.scenario.model import Carrying, Part, RobotSpec, Scenario
from world.report import result_of
from world.world import WorldCore

SMALL, LARGE = 0.04, 0.05
SCENARIO = Scenario(
    (RobotSpec(1, SMALL, (0.0, 0.0), (0.0, 0.0)),),
    carrying=Carrying(0.02),
    parts=(
        Part(LARGE, (0.095, 0.0), (0.0, 0.2)),  # nearer than the larger disk may be
        Part(LARGE, (-0.105, 0.0), (0.0, -0.2)),
    ),
)


class _Scripted:
    """A mover that does as it was told, and goes nowhere."""

    goal = aim = (0.0, 0.0)
    claim = None

    def __init__(self) -> None:
        self.radius, self.held = SMALL, 0
        self.handles: Handling | None = None

    def look(self, *_: Any) -> None: ...


def test_who_was_ready_for_one_part_takes_no_other_up_on_it() -> None:
    world = WorldCore(replace(SCENARIO, control=replace(SCENARIO.control, k=5.0)))
    core = Robot(world.scenario, 1, world.coordinator.join(1))
    mover = core._mover = _Scripted()  # type: ignore[assignment]

    def tick() -> None:
        core.begin(world.open_tick()[1])
        assert world.accept(core.command())
        world.close_tick()

    tick()
    mover.radius, mover.held = LARGE, 1
    tick()
    assert core._filter is not None
    assert core._filter.radius == LARGE
    mover.held, mover.handles = 2, Handling(2, LARGE)
    tick()
    assert core._filter.radius == SMALL
    mover.held, mover.handles = 1, Handling(1, LARGE)
    tick()
    assert [place.carrier for place in world.coordinator.parts.places] == [1, 0]
    assert result_of(world)["collisions"] == 0
