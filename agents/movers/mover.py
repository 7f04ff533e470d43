"""One robot as a mover: which part it claims, where it goes for it, and what it asks to do with it.

Everybody makes up its own mind: from the roster, which says where parts are, and from what peers claim in
their States. Claims are no locks. Two robots may go for the same part; the nearer goes on, the other turns to
something else, and only one of them gets it from the coordinator.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

from agents.movers.plan import Errand, Planner
from agents.movers.traffic import Traffic, Traveller
from agents.peers.state import PeerState
from agents.roster import KnownRoster
from protocol.geometry import Disk, Shape
from protocol.messages import Claim, Handling, Member
from protocol.scenario.model import Part, Scenario

Vector = tuple[float, float]

AGAIN: Final = 1.0  # s until a robot without a part looks for one again
STUCK: Final = 8.0  # s without motion, after which it turns to something else
MOVED: Final = 0.3  # of the own radius, less than which is no motion


class Mover:
    """What one robot does about parts.

    Args:
        scenario: the run, with the radii of robots that carry nothing.
        robot: own id.

    Attributes:
        goal: where to go, m.
        aim: where to go straight to for that, m; None to leave that to the law.
        claim: what peers are told.
        radius: of the disk that has to be kept clear, m.
        handles: what to ask for, once the disk is kept clear.
        held: the thing that is about to be taken up, which only the smaller disk keeps clear of; 0 for none.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        spec = scenario.spec(robot)
        self.goal = self._home = spec.goal
        self.claim: Claim | None = None
        self.radius = self._small = spec.radius
        self.handles: Handling | None = None
        self.held = 0
        self._planner = Planner(scenario, spec.radius)
        self.aim: Vector | None = None
        self._traffic = Traffic(self._planner.grid)
        self._robot, self._scenario = robot, scenario
        self._homes = {each.id: each.goal for each in scenario.robots}
        self._reach = scenario.carrying.reach
        self._patience, self._pause = scenario.ticks(STUCK), scenario.ticks(AGAIN)
        self._task = 0  # part that is fetched or carried
        self._look = -1  # tick from which on to look for a part again
        self._place: Vector | None = None  # beside the part, or where it is put down
        self._target: Vector | None = None  # where the part is put down, once that is decided
        self._loaded = False
        self._attempt = 0  # to put it down
        self._refuge: Vector | None = None  # where it makes way for others
        self._back = 0  # when it comes back from there, tick
        self._makes_room = False  # whether it takes the part up because that is in another's place
        self._floor: object = None  # what `_place` was found for
        self._anchor, self._since = spec.start, 0  # where it stands, and since when, tick
        self._avoided: dict[int, int] = {}  # parts that could not be reached, until a tick

    def look(
        self,
        tick: int,
        position: Vector,
        roster: KnownRoster,
        peers: Sequence[PeerState],
        standing: Iterable[Member],
        ordered: Vector | None = None,
    ) -> None:
        """Make up one's mind for a tick.

        Args:
            position: own, m.
            peers: what others said last.
            standing: disks of robots that stand.
            ordered: where an operator wants it to be, m, which goes first.
        """
        self._tick, self._position = tick, position
        self._stand = {each.robot: each for each in standing}
        self._peers = [state for state in peers if state.robot not in self._stand]
        self._carriers = {each.carrier: each.part for each in roster.parts if each.carrier}
        self._things = {each.part: each.thing for each in roster.parts if not each.carrier}
        self._at = self._floor_of(roster)
        self.goal, self.claim, self.handles = self._home, None, None
        self.radius, self.held, self.aim = self._small, 0, None
        if ordered is not None:
            self.goal, self._task, self._place = ordered, 0, None
            return
        if math.dist(position, self._anchor) > MOVED * self._small:
            self._anchor, self._since = position, tick
        carried = self._carriers.get(self._robot, 0)
        if self._loaded and not carried:
            self._task = 0  # it is put down
        self._loaded = carried != 0
        if carried:
            self._carry(carried)
        elif self._task and self._is_mine(self._task):
            self._fetch(self._task)
        else:
            self._choose()
        self.aim = self._aim()

    def _aim(self) -> Vector:
        """Where to go straight to."""
        if self.handles is not None:
            return self.goal
        size = max(self.radius, self._planner.loaded(self._task) if self._carries else self._small)
        me = Traveller(self._position, self.goal, size, self._among(self._task if self._carries else 0))
        mine = self._rank(self._robot, self.claim, self._position)
        first = [
            self._traveller(peer)
            for peer in self._peers
            if self._rank(peer.robot, peer.claim, peer.position) < mine
        ]
        return self._traffic.aim(me, [each for each in first if each is not None])

    @property
    def _carries(self) -> bool:
        return self._robot in self._carriers

    def _rank(self, robot: int, claim: Claim | None, at: Vector | None) -> tuple[int, float, int]:
        """Who goes first: who carries, then who fetches, then who is farthest from where it rests."""
        if robot in self._carriers:
            return 0, 0.0, robot
        if claim is not None:
            return 1, 0.0, robot
        return 2, 0.0 if at is None else -math.dist(at, self._homes.get(robot, at)), robot

    def _traveller(self, peer: PeerState) -> Traveller | None:
        """Where a peer goes, as far as can be told."""
        if peer.position is None:
            return None
        part = 0 if peer.claim is None else peer.claim.part
        if not 0 < part <= len(self._scenario.parts):
            home = self._homes.get(peer.robot, peer.position)
            return Traveller(peer.position, home, peer.radius, self._among(0))
        carries = self._carriers.get(peer.robot) == part
        to = self._spec(part).goal if carries else self._at.get(part, peer.position)
        radius = max(peer.radius, self._spec(part).radius) if carries else self._small
        return Traveller(peer.position, to, radius, self._among(part))

    def _among(self, part: int) -> tuple[Shape, ...]:
        """All that stands but one part."""
        parts = [Disk(*at, self._spec(each).radius) for each, at in self._at.items() if each != part]
        return (*(thing.shape for thing in self._scenario.things), *self._others, *parts)

    def _floor_of(self, roster: KnownRoster) -> dict[int, Vector]:
        """Where parts on the floor stand, m."""
        came = {thing.number: thing.points[0] for thing in roster.things if thing.status == "standing"}
        first, parts = len(self._scenario.things), self._scenario.parts
        listed = {first + number: part.start for number, part in enumerate(parts, 1)}
        known = {**listed, **came}
        return {part: known[thing] for part, thing in self._things.items() if thing in known}

    @property
    def _others(self) -> list[Shape]:
        """Robots that stand."""
        return [Disk(*each.position, each.radius) for each in self._stand.values() if each.position]

    # -- which part

    def _is_mine(self, part: int) -> bool:
        """Whether it can still be fetched, and nobody else has the better claim."""
        if part not in self._at and self._fallen(part) is None:
            return False
        if part in self._at and math.dist(self._at[part], self._spec(part).goal) < 1e-9:
            return False
        mine = (self._cost(), self._robot)
        return all(mine < (claim.cost, robot) for robot, claim in self._claims if claim.part == part)

    @property
    def _claims(self) -> list[tuple[int, Claim]]:
        return [(state.robot, state.claim) for state in self._peers if state.claim is not None]

    def _cost(self) -> float:
        return math.inf if self._place is None else math.dist(self._position, self._place)

    def _fallen(self, part: int) -> Member | None:
        """Who stands with a part, its life over."""
        carrier = next((robot for robot, what in self._carriers.items() if what == part), 0)
        return self._stand.get(carrier)

    def _choose(self) -> None:
        """Look for a part, now and then."""
        self._task, self._place, self._target, self._makes_room = 0, None, None, False
        if self._tick < self._look:
            return
        self._look = self._tick + self._pause
        claimed = {claim.part for _, claim in self._claims}
        self._avoided = {part: until for part, until in self._avoided.items() if until > self._tick}
        for part in sorted(self._spare_of_fallen(claimed)):
            if self._begin_fallen(part):
                return
        errand = self._errand(claimed)
        if errand is not None:
            self._task, self._place, self._floor = errand.part, errand.fetch, self._state
            self._since = self._tick
            self._fetch(errand.part)

    def _errand(self, claimed: set[int]) -> Errand | None:
        """The nearest after which all others can be run, too; where there is no order for all, one that makes
        room."""
        errands = [
            errand
            for errand in self._planner.errands(self._position, self._at, self._others)
            if errand.part not in claimed and errand.part not in self._avoided
        ]
        after = self._after(claimed)
        for errand in errands:
            if self._planner.leads_on(errand, after, self._others) and self._agrees(errand, after):
                return errand
        if claimed:
            return None
        clearing = self._planner.clearing(self._position, self._at, self._others)
        self._makes_room = clearing is not None
        return clearing or next(iter(errands), None)

    def _agrees(self, errand: Errand, after: dict[int, Vector]) -> bool:
        """Whether it does not matter who is first, this robot or those who have claimed other parts."""
        done = {**self._at, errand.part: self._spec(errand.part).goal}
        for peer in self._peers:
            claim = peer.claim
            if claim is None or peer.position is None or not 0 < claim.part <= len(self._scenario.parts):
                continue
            if claim.part in done:
                found: object = self._planner.errand(claim.part, peer.position, done, self._others)
            else:
                goal = self._spec(claim.part).goal
                found = self._planner.delivery(claim.part, goal, peer.position, done, self._others)
            if found is None:
                return False
        return self._planner.errand(errand.part, self._position, after, self._others) is not None

    def _spare_of_fallen(self, claimed: set[int]) -> set[int]:
        """Parts that robots carry whose lives are over."""
        return {
            part
            for robot, part in self._carriers.items()
            if robot in self._stand and part not in claimed and part not in self._avoided
        }

    def _begin_fallen(self, part: int) -> bool:
        self._task, self._place, self._since = part, None, self._tick
        self._fetch(part)
        return self._task == part and self._place is not None

    def _after(self, claimed: set[int]) -> dict[int, Vector]:
        """Where parts stand once those who are claimed are at their goals, m."""
        return {
            part: self._spec(part).goal if part in claimed or part not in self._at else self._at[part]
            for part in range(1, len(self._scenario.parts) + 1)
        }

    @property
    def _state(self) -> object:
        """What places were found for."""
        return tuple(sorted(self._at.items())), tuple(sorted(self._stand))

    # -- what to do about it

    def _fetch(self, part: int) -> None:
        """Go to a part and take it up."""
        fallen = self._fallen(part)
        if fallen is not None and fallen.position is not None:
            centre, size = fallen.position, fallen.radius
        else:
            centre, size = self._at[part], self._spec(part).radius
            self.held = self._things[part]
        grown = self._planner.loaded(part)
        if self._place is None or self._floor != self._state:
            self._floor = self._state
            if fallen is None:
                disk = Disk(*centre, size)
                found = self._planner.errand(part, self._position, self._at, self._others)
                self._place = (
                    self._planner.beside(self._position, disk, grown, self._rest(part))
                    if found is None
                    else found.fetch
                )
            else:
                self._place = self._planner.beside(
                    self._position, Disk(*centre, size), grown, self._rest(part)
                )
        if self._place is None or self._is_stuck():
            self._give_up(part)
            return
        self.goal = self._place
        self.claim = Claim(part, self._cost(), grown)
        gap = math.dist(self._position, centre) - size - self._small
        if 0.0 <= gap <= self._reach and self._cost() < 0.5 * self._reach:
            self.radius = grown
            self.handles = Handling(part, grown)

    def _carry(self, part: int) -> None:
        """Bring a part to its goal and put it down; elsewhere, if there is no way to it for long."""
        spec, carried = self._spec(part), self._planner.loaded(part)
        stuck = self._is_stuck()
        if self._task != part or self._target is None:
            self._task, self._floor, self._target = part, None, spec.goal
            stuck |= self._makes_room
        if self._makes_room or (stuck and self._place is None):
            self._makes_room = False
            self._target = self._planner.spare(part, self._position, self._at, self._others) or spec.goal
        if self._floor != self._state or stuck:
            self._floor, self._since = self._state, self._tick
            self._attempt = self._attempt + 1 if stuck and self._place is not None else 0
            self._place = self._planner.delivery(
                part, self._target, self._position, self._at, self._others, self._attempt
            )
            if self._attempt:  # somebody may be shut in
                self._refuge = self._planner.refuge(part, self._position, self._at, self._others)
                self._back = self._tick + self._patience // 2
        self.radius, self.claim = carried, Claim(part, 0.0, carried)
        self.goal = self._position if self._place is None else self._place
        if self._refuge is not None and self._tick < self._back:
            self.goal = self._refuge
            return
        if self._place is None:
            return
        gap = math.dist(self._position, self._target) - spec.radius - carried
        if 0.0 <= gap <= self._reach and self._cost() < 0.5 * self._reach:
            self.handles = Handling(part, carried, self._target)

    def _is_stuck(self) -> bool:
        """Whether it has not moved for long."""
        return self._tick - self._since > self._patience

    def _give_up(self, part: int) -> None:
        """Turn to something else for a while."""
        self._avoided[part] = self._tick + self._patience
        self._task, self._place, self.held = 0, None, 0

    def _rest(self, part: int) -> list[Shape]:
        """All that stands beside a part that is to be taken up."""
        parts = [Disk(*at, self._spec(each).radius) for each, at in self._at.items() if each != part]
        robots = [
            Disk(*each.position, each.radius)
            for each in self._stand.values()
            if each.position and self._carriers.get(each.robot) != part
        ]
        return [*(thing.shape for thing in self._scenario.things), *parts, *robots]

    def _spec(self, part: int) -> Part:
        return self._scenario.parts[part - 1]
