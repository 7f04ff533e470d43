"""Where obstacles leave room for one only, one goes first and the others go back: none waits for ever."""

import pytest

from agents.law.jams import ASIDE, JAM, TURN, RightOfWay
from agents.peers.state import PeerState
from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.geometry import ConvexPolygon
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Obstacle, RobotSpec, Scenario, Time, Workspace

pytestmark = pytest.mark.slow

R = 0.05
STEP = 0.05  # s
LAP = 10  # ticks


def corridor(robots: int, law: str, half: float = 1.5 * R) -> Scenario:
    """Half of the robots on each side of a passage that is 0.8 m long, all with goals on the other side."""
    specs = []
    for n in range(robots):
        side, place = 1.0 - 2.0 * (n % 2), 0.2 * (n // 2) - 0.1 * (robots // 2 - 1)
        specs.append(RobotSpec(n + 1, R, (side * 0.7, place), (-side * 0.7, place)))
    walls = (
        Obstacle(points=((-0.4, half), (0.4, half), (0.4, 1.0), (-0.4, 1.0))),
        Obstacle(points=((-0.4, -1.0), (0.4, -1.0), (0.4, -half), (-0.4, -half))),
    )
    room = Workspace(points=((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)))
    time = Time(step=STEP, limit=180.0, tolerance=0.02)
    return resolved(
        validated(Scenario(tuple(specs), "corridor", "", 1, room, time, Control(law=law), obstacles=walls))
    )


@pytest.mark.parametrize("law", ["gradient", "reciprocal"])
def test_both_get_through_a_passage_that_is_wide_enough_for_one(law: str) -> None:
    """Without this they are in a deadlock."""
    report = LocalFleet(corridor(2, law)).execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)


def state(robot: int, x: float, gamma: float = 1.0, vx: float = 0.0) -> PeerState:
    return PeerState(robot, 1, 0, True, x, 0.0, 0.0, gamma, 1.0, vx, 0.0, radius=R)


WALLS = (
    ConvexPolygon([(0.0, 0.08), (2.0, 0.08), (2.0, 0.2), (0.0, 0.2)]),
    ConvexPolygon([(0.0, -0.2), (2.0, -0.2), (2.0, -0.08), (0.0, -0.08)]),
)


def jammed(robot: int, peer: PeerState, begin: int = 0) -> tuple[RightOfWay, tuple[float, float] | None, int]:
    """Drive from x = -0.5 m to 0.5 m, into the passage, and stand there until JAM is over."""
    right = RightOfWay(robot, R, LAP * STEP, STEP)
    tick = begin
    for tick in range(begin, begin + 21 + int(JAM + 1) * LAP):
        x = min(-0.5 + 0.05 * (tick - begin), 0.5)
        if right.yielding(tick, (2.5, 0.0)) is not None:
            break
        right.look(tick, (x, 0.0), 2.5 - x, [peer], WALLS)
    return right, right.yielding(tick, (2.5, 0.0)), tick


def test_exactly_one_of_two_goes_back_to_where_it_can_be_passed_and_in_the_next_turn_the_other() -> None:
    backs = []
    for turn in range(40):
        begin = int(turn * TURN * LAP)
        one, two = (jammed(own, state(other, 0.61), begin)[1] for own, other in ((1, 2), (2, 1)))
        assert (one is None) != (two is None)
        back = one or two
        assert back is not None
        assert all(wall.distance(*back) >= ASIDE * R for wall in WALLS)
        backs.append(one is not None)
    assert 5 < sum(backs) < 35
