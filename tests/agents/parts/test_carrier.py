"""What a carrier does in a corridor, where there is no spare place: never bring a part to its own home."""

from agents.parts.carrier import STUCK, PartCarrier
from agents.parts.perception import Perception
from agents.peers.neighbours import Neighbours
from agents.peers.state import addressed_to
from protocol.geometry import Disk
from protocol.messages import Claim, Handling, Member, PartPlace, PlacedObstacle, Roster, State, Vector
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


def test_an_order_takes_precedence_and_what_is_carried_goes_on_after_it() -> None:
    at = (-0.15, 0.0)
    setting = scenario(at, (-0.1, 0.0), (0.02, 0.0), (0.04, 0.0), None)
    carrier, known = PartCarrier(setting, 1), seen(setting, 1, 1, freed=True)
    carrier.look(0, at, known, None)
    before = carrier.goal
    carrier.look(1, at, known, (0.1, 0.0))
    assert (carrier.goal, carrier.aim, carrier.claim, carrier.handles) == ((0.1, 0.0), None, None, None)
    carrier.look(2, at, known, None)
    assert carrier.goal == before != at
    assert (carrier.claim, carrier.handles) == (Claim(1, 0.0, LARGE), None)
    carrier.look(3, before, known, None)
    assert (carrier.aim, carrier.handles) == (before, Handling(1, LARGE, (0.02, 0.0)))
    gone = PlacedObstacle(1, "gone"), PlacedObstacle(2, "gone")
    down = (
        PlacedObstacle(number, "standing", (place,), LARGE)
        for number, place in ((3, (-0.9, 0.0)), (4, (0.02, 0.0)))
    )
    parts = PartPlace(1, 4), PartPlace(2, 3)
    known.on_roster(Roster(2, (Member(1, 1, "live", SMALL),), (*gone, *down), parts))
    carrier.look(4, before, known, None)
    assert (carrier.goal, carrier.radius, carrier.claim, carrier.handles) == ((-0.1, 0.0), SMALL, None, None)


def on_the_floor(setting: Scenario, *members: Member) -> Neighbours:
    """What robot 1 knows before any part was moved."""
    neighbours = Neighbours({1: SMALL, 2: SMALL}, robot=1, listed=setting.shapes)
    parts = tuple(PartPlace(part, part) for part in setting.shapes)
    neighbours.on_roster(Roster(1, (Member(1, 1, "live", SMALL), *members), (), parts))
    return neighbours


def claimed(step: float) -> list[bool]:
    """In which ticks a robot claims a part, while it moves to and fro, m, and does not reach it."""
    part = Part(LARGE, (0.0, 0.0), (0.1, 0.0))
    robot = RobotSpec(1, SMALL, (-0.15, 0.0), (-0.15, 0.0))
    setting = Scenario((robot,), workspace=CORRIDOR, parts=(part,), carrying=Carrying(0.06))
    carrier, known, found = PartCarrier(setting, 1), on_the_floor(setting), []
    for tick in range(2 * setting.ticks(STUCK) + 20):
        carrier.look(tick, (-0.15 + step * (tick % 2), 0.0), known, None)
        found.append(carrier.claim is not None)
        assert (carrier.handles, carrier.radius, carrier.held) == (None, SMALL, int(found[-1]))
    return found


def test_a_robot_that_does_not_move_leaves_a_part_for_as_long_as_it_waited() -> None:
    assert all(claimed(0.012))
    found = claimed(0.0)
    waited, left = found.index(False), found[::-1].index(False)
    assert 0 < left < 20
    assert not any(found[waited:-left])
    assert len(found[waited:-left]) == waited


def test_a_peer_is_on_the_way_to_what_it_fetches_or_to_where_it_puts_down_what_it_carries() -> None:
    setting = scenario((-0.15, 0.0), (-0.15, 0.0), (0.05, 0.0), (0.13, 0.0), (-0.08, 0.0))
    state = State(2, 1, 1, (-0.08, 0.0), 0.0, 0.0, 0.0, (0.0, 0.0), claim=Claim(1, 0.1, LARGE))
    for carrier, to, leaves in ((0, (0.0, 0.0), ()), (2, (0.05, 0.0), (Disk(0.05, 0.0, LARGE),))):
        known = on_the_floor(setting, Member(2, 1, "live", SMALL))
        known.on_state(addressed_to(1, state, SMALL), 1)
        if carrier:
            parts = PartPlace(1, carrier=2), PartPlace(2, 2)
            members = Member(1, 1, "live", SMALL), Member(2, 1, "live", LARGE)
            known.on_roster(Roster(2, members, (PlacedObstacle(1, "gone"),), parts))
        perception = Perception(setting, known)
        (peer,) = perception.peers
        found = perception.traveller(peer)
        assert (found.to, found.radius, found.leaves) == (to, LARGE, leaves)
