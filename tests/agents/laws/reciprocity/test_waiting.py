"""Close to its goal a robot waits for who passes, moves for who comes at it, and does not wait for ever."""

from __future__ import annotations

import math
from dataclasses import replace

from agents.laws import View
from agents.laws.gradient import GradientLaw
from agents.laws.reciprocity.reciprocal import NEAR, ReciprocalLaw
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.messages import Vector
from protocol.scenario.model import Control, RobotSpec, Scenario, Workspace

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


def test_who_has_waited_in_vain_does_not_wait_again() -> None:
    law, beside = ReciprocalLaw(SCENARIO, 1), (HERE[0] - 3.5 * RADIUS, 0.0)
    long = round(40.0 * LAP / SCENARIO.time.step)
    wishes = [law.velocity(seen(tick, beside, (0.0, 0.0))) for tick in range(long)]
    begun = next(tick for tick, wish in enumerate(wishes) if wish != (0.0, 0.0))
    assert begun < 5.0 * LAP / SCENARIO.time.step
    assert (0.0, 0.0) not in wishes[begun:]


def test_two_that_change_places_side_by_side_in_a_pack_do_not_wait_for_ever() -> None:
    starts = (-0.0438754, -0.0759406), (-3.05e-5, -0.0001807), (-0.0882437, -0.000101), (-0.0441882, 0.07596)
    goals = (-0.044, -0.07621), (-0.088, 0.0), (0.0, 0.0), (-0.044, 0.07621)
    robots = zip(range(1, 5), starts, goals, strict=True)
    specs = tuple(RobotSpec(number, RADIUS, start, goal) for number, start, goal in robots)
    pack = Scenario(specs, workspace=Workspace(0.148), control=Control(law="reciprocal"))
    assert LocalFleet([resolved(pack)]).execute()[0]["verdict"] == "arrived"


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
