"""Where a carrier brings a part for which there is no spare place, in a corridor: never to its own home."""

from agents.parts.carrier import PartCarrier
from agents.peers.neighbours import Neighbours
from protocol.messages import Member, PartPlace, PlacedObstacle, Roster, Vector
from protocol.scenario.model import Carrying, Part, RobotSpec, Scenario, Workspace

SMALL, LARGE = 0.03, 0.04
CORRIDOR = Workspace(points=((-0.2, -0.055), (0.2, -0.055), (0.2, 0.055), (-0.2, 0.055)))


def scenario(start: Vector, home: Vector, goal: Vector, other: Vector, dead: Vector | None) -> Scenario:
    """Robot 1 and part 1 in the middle, whose goal another part bars; robot 2 may lie dead in the way."""
    robots = [RobotSpec(1, SMALL, start, home)] + ([RobotSpec(2, SMALL, dead, dead)] if dead else [])
    parts = (Part(LARGE, (0.0, 0.0), goal), Part(LARGE, other, (0.12, 0.0)))
    return Scenario(tuple(robots), workspace=CORRIDOR, parts=parts, carrying=Carrying(0.06))


def seen(setting: Scenario, version: int, carrier: int, *, freed: bool = False) -> Neighbours:
    """What robot 1 knows while robot `carrier` has part 1; `freed`: the other part is elsewhere."""
    radii = {spec.id: spec.radius for spec in setting.robots}
    neighbours = Neighbours(radii, robot=1, listed=setting.shapes)
    sizes = {spec.id: LARGE if spec.id == carrier else SMALL for spec in setting.robots}
    members = [Member(1, 1, "live", sizes[1])]
    members += [Member(spec.id, 1, "standing", sizes[spec.id], spec.start) for spec in setting.robots[1:]]
    obstacles = [PlacedObstacle(1, "gone")]
    if freed:
        obstacles += [PlacedObstacle(2, "gone"), PlacedObstacle(3, "standing", ((-0.9, 0.0),), LARGE)]
    parts = PartPlace(1, carrier=carrier), PartPlace(2, 3 if freed else 2)
    neighbours.on_roster(Roster(version, tuple(members), tuple(obstacles), parts))
    return neighbours


def test_a_new_life_that_is_stuck_keeps_the_goal_of_its_part() -> None:
    setting = scenario((0.0, 0.0), (-0.1, 0.0), (0.12, 0.0), (0.02, 0.0), None)
    carrier, known = PartCarrier(setting, 1), seen(setting, 1, 1)
    for tick in range(400):
        carrier.look(tick, (0.0, 0.0), known, None)
    assert carrier._target == (0.12, 0.0)


def test_what_was_taken_from_a_dead_robot_is_delivered_once_its_goal_is_free() -> None:
    setting = scenario((-0.02, 0.0), (0.19, 0.0), (0.1, 0.0), (0.04, 0.0), (-0.11, 0.0))
    carrier, known = PartCarrier(setting, 1), seen(setting, 1, 2, freed=True)
    for tick in range(60):
        carrier.look(tick, carrier._place or (-0.02, 0.0), known, None)
    place = carrier._place
    assert place is not None
    known = seen(setting, 2, 1)
    for tick in range(60, 600):
        carrier.look(tick, place, known, None)
    assert carrier._place is None
    known = seen(setting, 3, 1, freed=True)
    for tick in range(600, 1000):
        carrier.look(tick, place, known, None)
    assert carrier._target == (0.1, 0.0)
    assert carrier._place is not None
