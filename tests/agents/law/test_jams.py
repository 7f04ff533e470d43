"""Crowds come apart, robots at their goals let others by, and in narrow passages one goes first."""

import math
from random import Random

import pytest

from agents.law.jams import ASIDE, CROWD, JAM, QUEUE, TURN, WAIT, GivingWay
from agents.peers.state import PeerState
from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.geometry import ConvexPolygon
from protocol.messages import Vector
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Obstacle, RobotSpec, Scenario, Time, Workspace

R = 0.04
STEP = 0.05  # s
LAP = 8  # ticks
FAR = (1.0, 0.0)  # a goal


def state(robot: int, x: float, y: float, gamma: float = 1.0, radius: float = R) -> PeerState:
    return PeerState(robot, 1, 0, True, x, y, 0.0, gamma, 1.0, 0.0, 0.0, radius=radius)


def ring(robots: int, gamma: float = 1.0) -> list[PeerState]:
    """So many touch each other around (0.1, 0), the robots from 2 on."""
    size = 1.02 * R / math.sin(math.pi / robots)
    angles = [2.0 * math.pi * n / robots for n in range(robots)]
    return [
        state(n + 2, 0.1 + size * math.cos(angle), size * math.sin(angle), gamma)
        for n, angle in enumerate(angles)
    ]


def pressed(own: int, places: dict[int, Vector], *, stuck: bool = True) -> GivingWay:
    """A robot that has stood in a crowd for JAM."""
    jams = GivingWay(own, R, LAP * STEP, STEP)
    others = [state(robot, *place) for robot, place in places.items() if robot != own]
    for tick in range(int(JAM * LAP) + 2):
        if jams.yielding(tick, FAR) is None:
            jams.look_in_the_open(tick, places[own], 0.9, others, stuck=stuck)
    return jams


def test_all_but_one_of_a_crowd_spread_and_stand_for_a_while() -> None:
    places = {1: (0.1, 0.0)} | {peer.robot: (peer.x, peer.y) for peer in ring(CROWD - 1)}
    now = int(JAM * LAP) + 2
    few = dict(list(places.items())[1:])
    assert all(pressed(own, few).yielding(now, FAR) is None for own in few)
    went = []
    for own, (x, y) in places.items():
        assert pressed(own, places, stuck=False).yielding(now, FAR) is None
        jams = pressed(own, places)
        back = jams.yielding(now, FAR)
        if back is None:
            went.append(own)
        else:
            assert back == pytest.approx((2.0 * x - 0.1, 2.0 * y), abs=1e-9)
            last = int((JAM + WAIT + QUEUE * CROWD) * LAP) + 2
            assert jams.yielding(int((JAM + WAIT) * LAP), FAR) == back
            assert jams.yielding(last, FAR) is None
    assert len(went) == 1


def arrived(moves: float = 0.0, gamma: float = 1.0) -> tuple[float, float] | None:
    """Where a robot at its goal steps aside to for another beside it that moves by so much, m, in JAM."""
    jams = GivingWay(1, R, LAP * STEP, STEP)
    for tick in range(int(2.5 * JAM * LAP)):
        back = jams.yielding(tick, (0.0, 0.0))
        if back is not None:
            return back
        peer = state(2, 0.081, moves * tick / (JAM * LAP), gamma)
        jams.look_in_the_open(tick, (0.0, 0.0), 0.0, [peer], stuck=False)
    return None


def test_a_robot_that_stands_at_its_goal_steps_aside_for_one_that_stands_beside_it() -> None:
    assert arrived() == pytest.approx((-0.0405, 0.0))
    assert arrived(moves=R) is None
    assert arrived(gamma=R * R) is None


def gate() -> Scenario:
    """Two at their goals, less than a disk apart, and one that wants through between them."""
    specs = (
        RobotSpec(1, R, (0.0, 0.3), (0.0, -0.12)),
        RobotSpec(2, R, (-0.07, 0.0), (-0.07, 0.0)),
        RobotSpec(3, R, (0.07, 0.0), (0.07, 0.0)),
        RobotSpec(4, R, (-0.2, -0.06), (-0.2, -0.06)),
        RobotSpec(5, R, (0.2, -0.06), (0.2, -0.06)),
    )
    time = Time(step=STEP, limit=60.0, deadlock=60.0)
    control = Control(k=1e6)
    return resolved(validated(Scenario(specs, "gate", "", 1, Workspace(0.6), time, control)))


def crowd() -> Scenario:
    """19 packed as tightly as disks can be, each bound for somewhere on the far side."""
    draw = Random(1)
    pitch, span = 2.005 * R, range(-6, 7)
    cells = [(pitch * (i + 0.5 * (j % 2)), pitch * math.sqrt(0.75) * j) for i in span for j in span]
    cells.sort(key=lambda cell: (math.hypot(*cell), cell))
    specs: list[RobotSpec] = []
    for x, y in cells[:19]:
        goal = x, y
        while any(math.dist(goal, other) < 3.0 * R for other in [(x, y), *[spec.goal for spec in specs]]):
            angle, away = math.atan2(-y, -x) + draw.uniform(-1.2, 1.2), draw.uniform(0.7, 2.1)
            goal = round(away * math.cos(angle), 6), round(away * math.sin(angle), 6)
        specs.append(RobotSpec(len(specs) + 1, R, (round(x, 6), round(y, 6)), goal))
    time, control = Time(limit=60.0, deadlock=60.0), Control(k=1e6)
    return resolved(validated(Scenario(tuple(specs), "crowd", "", 1, Workspace(2.2), time, control)))


# -- in narrow passages

WIDE = 0.05  # m, radius
PASSAGE_LAP = 10  # ticks


def corridor(law: str) -> Scenario:
    """One robot on each side of a passage that is 0.8 m long, with its goal on the other side."""
    specs = RobotSpec(1, WIDE, (0.7, 0.0), (-0.7, 0.0)), RobotSpec(2, WIDE, (-0.7, 0.0), (0.7, 0.0))
    half = 1.5 * WIDE
    walls = (
        Obstacle(points=((-0.4, half), (0.4, half), (0.4, 1.0), (-0.4, 1.0))),
        Obstacle(points=((-0.4, -1.0), (0.4, -1.0), (0.4, -half), (-0.4, -half))),
    )
    room = Workspace(points=((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)))
    time = Time(step=STEP, limit=180.0, tolerance=0.02)
    return resolved(
        validated(Scenario(specs, "corridor", "", 1, room, time, Control(law=law), obstacles=walls))
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "scenario",
    [gate(), corridor("gradient"), corridor("reciprocal"), pytest.param(crowd(), marks=pytest.mark.campaign)],
    ids=["between two at their goals", "a passage for one", "by the other law", "a crowd comes apart"],
)
def test_robots_get_through(scenario: Scenario) -> None:
    """Without this they are in a deadlock, or do not within their time."""
    report = LocalFleet(scenario).execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)


WALLS = (
    ConvexPolygon([(0.0, 0.08), (2.0, 0.08), (2.0, 0.2), (0.0, 0.2)]),
    ConvexPolygon([(0.0, -0.2), (2.0, -0.2), (2.0, -0.08), (0.0, -0.08)]),
)


def jammed(robot: int, peer: PeerState, begin: int) -> tuple[float, float] | None:
    """Where a robot backs off to after JAM, if it has driven from x = -0.5 m to 0.5 m, into the passage."""
    right = GivingWay(robot, WIDE, PASSAGE_LAP * STEP, STEP)
    for tick in range(begin, begin + 21 + int(JAM + 1) * PASSAGE_LAP):
        x = min(-0.5 + 0.05 * (tick - begin), 0.5)
        back = right.yielding(tick, (2.5, 0.0))
        if back is not None:
            return back
        right.look_in_passages(tick, (x, 0.0), 2.5 - x, [peer], WALLS)
    return None


@pytest.mark.slow
def test_exactly_one_of_two_goes_back_to_where_it_can_be_passed_and_in_the_next_turn_the_other() -> None:
    backs = []
    for turn in range(40):
        begin = int(turn * TURN * PASSAGE_LAP)
        one, two = (jammed(own, state(3 - own, 0.61, 0.0, radius=WIDE), begin) for own in (1, 2))
        assert (one is None) != (two is None)
        back = one or two
        assert all(wall.distance(*back) >= ASIDE * WIDE for wall in WALLS)
        backs.append(one is not None)
    assert 5 < sum(backs) < 35
