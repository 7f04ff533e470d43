"""The carrier of one robot: claims a part, sets the robot's goal, and requests to take the part up or put it
down.

Each robot decides by the places of parts in the roster and the claims in peers' States. A claim is no lock:
of two robots that approach the same part the nearer continues, the other chooses another, and the coordinator
grants it to one of them only.
"""

from __future__ import annotations

import math
from typing import Final

from agents.parts.grid import Layout
from agents.parts.perception import Perception, Traffic, Traveller
from agents.parts.planner import Planner
from agents.peers.neighbours import Neighbours
from protocol.messages import Claim, Handling, Vector
from protocol.scenario.model import Part, Scenario

AGAIN: Final = 1.0  # s between searches of a robot without a part
STUCK: Final = 8.0  # s without motion after which it gives up its task for a while
MOVED: Final = 0.3  # least motion, own radii


class PartCarrier:
    """Fetches and delivers parts for one robot."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        spec = scenario.spec(robot)
        self.goal = self._home = spec.goal  # of the robot, m
        self.claim: Claim | None = None  # published in the robot's State
        self.radius = self._small = spec.radius  # of the disk that must be kept clear, m
        self.handles: Handling | None = None  # the request to publish once the disk is kept clear
        # The obstacle that is about to be taken up, which constrains only the smaller disk; 0 for none.
        self.held = 0
        self.aim: Vector | None = None  # next waypoint, m, straight ahead; None: the law leads to the goal
        self._planner = Planner(scenario, spec.radius)
        self._traffic = Traffic(self._planner.grid)
        self._robot, self._scenario = robot, scenario
        self._reach = scenario.carrying.reach
        self._patience, self._pause = scenario.ticks(STUCK), scenario.ticks(AGAIN)
        self._task = 0  # part that is fetched
        self._look = -1  # tick from which on to look for a part again
        self._place: Vector | None = None  # from where the robot takes the part up or puts it down
        self._target: Vector | None = None  # of the carried part
        self._origin: Vector | None = None  # where it was taken up from the floor
        self._attempt = 0  # number of the attempt to put it down
        self._known: dict[int, int] = {}  # claims of peers at the last check of the plan
        self._in_order = False  # whether all parts can be delivered after this one
        self._refuge: Vector | None = None  # place to make way for other robots
        self._back = 0  # tick at which it returns from there
        self._seen: Layout | None = None  # layout for which `_place` was found
        self._anchor, self._since = spec.start, 0  # place and tick of its last stop
        self._avoided: dict[int, int] = {}  # unreachable parts, avoided until a tick

    def look(self, tick: int, position: Vector, peers: Neighbours, ordered: Vector | None) -> None:
        """Decide for a tick, at `position`, m. `ordered`: goal of an operator's order, m, which takes
        precedence."""
        self._tick, self._position = tick, position
        self._perception = Perception(self._scenario, peers)
        self.goal, self.claim, self.handles = self._home, None, None
        self.radius, self.held, self.aim = self._small, 0, None
        if ordered is not None:
            self.goal, self._task, self._place, self._target = ordered, 0, None, None
            return
        if math.dist(position, self._anchor) > MOVED * self._small:
            self._anchor, self._since = position, tick
        carried = self._perception.carriers.get(self._robot, 0)
        if carried:
            self._carry(carried)
        elif self._is_mine(self._task) and self._fits(self._task):
            self._fetch(self._task)
        else:
            self._choose()
        self.aim = self._aim()

    # -- on the way

    def _aim(self) -> Vector:
        if self.handles is not None:
            return self.goal
        part = self._perception.carriers.get(self._robot, 0)
        me = Traveller(self._position, self.goal, self.radius, self._perception.among(part))
        ahead = self._perception.first(self._robot, self.claim)
        found = [self._perception.traveller(peer) for peer in ahead]
        return self._traffic.aim(me, [each for each in found if each is not None])

    # -- which part

    def _is_mine(self, part: int) -> bool:
        """Whether a part can still be fetched, and no peer has a better claim."""
        mine = (self._cost(), self._robot)
        return part in self._perception.layout.parts and all(
            mine < (claim.cost, robot) for robot, claim in self._perception.claims if claim.part == part
        )

    def _fits(self, part: int) -> bool:
        """Whether a part is compatible with the newest claims of robots that take precedence, which may have
        been made at the same time. A claim yields to that of a nearer robot, and bars no other."""
        claims = {robot: claim.part for robot, claim in self._perception.claims}
        if claims == self._known or not self._in_order:
            return True
        self._known = claims
        farthest = sorted(self._perception.claims, key=lambda each: (each[1].cost, each[0]), reverse=True)
        nearest = {claim.part: robot for robot, claim in farthest} | {part: self._robot}
        ahead = [
            peer.robot
            for peer in self._perception.first(self._robot, Claim(part, 0.0, 0.0))
            if peer.robot not in claims or nearest[claims[peer.robot]] == peer.robot
        ]
        perception = self._perception.heeding(ahead)
        return self._planner.fits(part, self._position, perception)

    def _cost(self) -> float:
        return math.inf if self._place is None else math.dist(self._position, self._place)

    def _choose(self) -> None:
        self._task, self._place, self._target = 0, None, None
        if self._tick < self._look:
            return
        self._look = self._tick + self._pause
        self._avoided = {part: until for part, until in self._avoided.items() if until > self._tick}
        perception = self._perception
        errand = self._planner.choose(self._position, perception, self._avoided)
        if errand is not None:
            self._task, self._place, self._seen = errand.part, errand.fetch, perception.layout
            self._since, self._known = self._tick, {robot: claim.part for robot, claim in perception.claims}
            self._in_order = self._planner.leads_on(errand.part, perception.layout, self._position)
            self._fetch(errand.part)

    # -- fetching and carrying

    def _fetch(self, part: int) -> None:
        layout, grown = self._perception.layout, self._planner.loaded(part)
        if self._seen is not None and (self._seen.others, self._seen.held) != (layout.others, layout.held):
            self._look = self._tick  # another static disk or obstacle: choose again
            self._choose()
            return
        if self._seen != layout:
            self._seen = layout
            self._place = self._planner.fetch(part, self._position, layout)
        if self._place is None or self._is_stuck():
            self._task, self._avoided[part] = 0, self._tick + self._patience
            return
        self.goal, self.held = self._place, self._perception.obstacles.get(part, 0)
        self.claim = Claim(part, self._cost(), grown)
        size = layout.held.get(part, self._spec(part).radius)
        if self._is_beside(layout.parts[part], size + self._small):
            self.radius, self._origin = grown, None if part in layout.held else layout.parts[part]
            self.handles = Handling(part, grown)

    def _carry(self, part: int) -> None:
        """Bring a part to its goal and put it down; elsewhere, if that leaves the others a path, or if there
        is no path for long."""
        spec, carried, layout = self._spec(part), self._planner.loaded(part), self._perception.layout
        stuck, planner = self._is_stuck(), self._planner
        self._task = 0
        if self._target is None:
            self._seen, self._target = None, spec.goal
        if stuck and self._place is None:
            back = self._origin if self._target == spec.goal else None
            self._target = planner.spare(part, self._position, layout) or back or spec.goal
        elif self._seen != layout and self._target == spec.goal:
            self._target = planner.destination(part, self._position, layout)
        if self._seen != layout or stuck:
            self._seen, self._since = layout, self._tick
            self._attempt = self._attempt + 1 if stuck and self._place is not None else 0
            self._place = planner.delivery(part, self._target, self._position, layout, self._attempt)
            if self._attempt:  # another robot may be enclosed
                self._refuge = planner.refuge(part, self._position, layout)
                self._back = self._tick + self._patience // 2
        self.radius, self.claim = carried, Claim(part, 0.0, carried)
        self.goal = self._position if self._place is None else self._place
        if self._refuge is not None and self._tick < self._back:
            self.goal = self._refuge
            return
        if self._is_beside(self._target, spec.radius + carried):
            self.handles = Handling(part, carried, self._target)

    def _is_beside(self, centre: Vector, touching: float) -> bool:
        """Whether a part or its target is within reach, and the robot near its own place."""
        gap = math.dist(self._position, centre) - touching
        return 0.0 <= gap <= self._reach and self._cost() < 0.5 * self._reach

    def _is_stuck(self) -> bool:
        return self._tick - self._since > self._patience

    def _spec(self, part: int) -> Part:
        return self._scenario.parts[part - 1]
