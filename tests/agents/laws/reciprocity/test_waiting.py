"""Close to its goal a robot waits for who passes, moves for who comes at it, and does not wait for ever."""

from __future__ import annotations

import math
from dataclasses import replace

from agents.laws import View
from agents.laws.gradient import GradientLaw
from agents.laws.reciprocity.reciprocal import NEAR, ReciprocalLaw
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from protocol.messages import Vector
from protocol.scenario.model import Control, RobotSpec, Scenario

RADIUS = 0.04
GOAL = (0.0, 0.0)
HERE = (0.5 * RADIUS, 0.0)
SCENARIO = Scenario(
    (RobotSpec(1, RADIUS, (-0.3, 0.0), GOAL), RobotSpec(2, RADIUS, (0.3, 0.0), (-0.1, 0.35))),
    control=Control(law="reciprocal", k=60.0),
)
LAP = RADIUS / SCENARIO.control.speed


def seen(tick: int, peer: Vector, velocity: Vector) -> View:
    """Robot 1 half a radius from its goal; the peer is on the side of the goal, and drives it away."""
    known = Neighbours({2: RADIUS})
    gamma = math.dist(peer, SCENARIO.robots[1].goal) ** 2
    known.on_state(PeerState(2, 1, tick, True, *peer, 0.0, gamma, 0.0, *velocity, radius=RADIUS))
    return View(tick=tick, position=HERE, goal=GOAL, displacement=(0.0, 0.0), neighbours=known)


def test_who_passes_is_waited_for() -> None:
    beside = (HERE[0] - 2.4 * RADIUS, 0.0)
    view = seen(0, beside, (0.0, SCENARIO.control.speed))
    assert GradientLaw(SCENARIO, 1).velocity(view)[0] > 0.0  # the flow would back off
    assert ReciprocalLaw(SCENARIO, 1).velocity(view) == (0.0, 0.0)


def test_who_comes_at_the_robot_is_made_room_for() -> None:
    beside = (HERE[0] - 2.4 * RADIUS, 0.0)
    view = seen(0, beside, (SCENARIO.control.speed, 0.0))
    assert ReciprocalLaw(SCENARIO, 1).velocity(view)[0] > 0.0


def test_nobody_is_waited_for_for_ever() -> None:
    law, beside = ReciprocalLaw(SCENARIO, 1), (HERE[0] - 2.4 * RADIUS, 0.0)
    soon = round(5.0 * LAP / SCENARIO.time.step)
    wishes = [law.velocity(seen(tick, beside, (0.0, 0.0))) for tick in range(soon)]
    assert wishes[0] == (0.0, 0.0) != wishes[-1]


def test_without_the_escape_which_ends_a_wait_nobody_waits() -> None:
    alone = replace(SCENARIO, control=replace(SCENARIO.control, escape=False))
    view = seen(0, (HERE[0] - 2.4 * RADIUS, 0.0), (0.0, SCENARIO.control.speed))
    assert ReciprocalLaw(alone, 1).velocity(view) == GradientLaw(alone, 1).velocity(view) != (0.0, 0.0)


def test_far_from_the_goal_nobody_waits() -> None:
    x = 1.5 * NEAR * RADIUS
    known = Neighbours({2: RADIUS})
    known.on_state(PeerState(2, 1, 0, True, x - 2.2 * RADIUS, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, radius=RADIUS))
    view = View(tick=0, position=(x, 0.0), goal=GOAL, displacement=(0.0, 0.0), neighbours=known)
    assert ReciprocalLaw(SCENARIO, 1).velocity(view) != (0.0, 0.0)
