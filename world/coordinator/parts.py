"""Parts: which are on the floor, and which robot carries which. Robots request changes in their Commands.

When a part is taken up, its obstacle is removed, and in the same version of the roster its carrier becomes
the larger disk, which it has kept clear beforehand. A part that is put down appears like an obstacle, once
all robots keep clear of its place; until then its carrier remains the larger disk. A silent carrier is static
with its part, which another robot may take from there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from protocol.geometry import Disk, Shape
from protocol.messages import Handling, PartPlace, Vector
from protocol.scenario.model import Part, Scenario
from world.coordinator.lives import Lives

_ROUNDING = 1e-9  # m


class Parts:
    """The parts of one run.

    Args:
        scenario: with the radii of robots without parts.
        lives: of the robots; if their roster has no parts yet, these are at the scenario's places.
    """

    def __init__(self, scenario: Scenario, lives: Lives) -> None:
        self._scenario, self._lives = scenario, lives
        first = len(scenario.obstacles)
        self._places = {part: PartPlace(part, first + part) for part in range(1, len(scenario.parts) + 1)}
        self._places.update({each.part: each for each in lives.roster.message.parts})
        lives.roster.follow(self.places)

    @property
    def places(self) -> tuple[PartPlace, ...]:
        """Places of all parts, ascending."""
        return tuple(self._places.values())

    def in_place(self, part: int) -> bool:
        """Whether a part is on the floor at its goal."""
        place, known = self._places[part], self._lives.obstacles.standing
        if place.obstacle not in known:
            return False
        spec, tolerance = self._spec(part), self._scenario.time.tolerance
        return known[place.obstacle].distance(*spec.goal) <= tolerance - spec.radius

    @property
    def pending(self) -> bool:
        """Whether any part is not at its goal."""
        return not all(map(self.in_place, self._places))

    def carried_by(self, robot: int) -> int:
        """Part that a robot carries, 0 if none."""
        return next((each.part for each in self.places if each.carrier == robot), 0)

    def owns(self, obstacle: int) -> int:
        """Part that is, or will be, an obstacle; 0 if none."""
        return next((each.part for each in self.places if each.obstacle == obstacle), 0)

    def set_fleet(self, scenario: Scenario) -> None:
        """Set the robots after a change of the fleet."""
        self._scenario = scenario

    @property
    def loaded(self) -> Scenario:
        """The scenario with the disks of robots and what they carry."""
        radius, carried = self._scenario.loaded_radius, [each for each in self.places if each.carrier]
        return self._scenario.resized({each.carrier: radius(each.carrier, each.part) for each in carried})

    def handle(self, asked: Mapping[int, Handling | None], at: Mapping[int, Vector]) -> bool:
        """Execute active robots' requests in the tick that ends, with all disks `at` their places (m);
        returns whether a disk changed.
        """
        before = self.places
        for robot in sorted(asked):
            handles = asked[robot]
            if handles is not None and handles.place is None and handles.part in self._places:
                self._take(robot, handles, at)
        for place in self.places:
            if place.carrier:
                self._put(place, asked.get(place.carrier), place.carrier in asked, at)
        self._lives.roster.follow(self.places)
        return [each.carrier for each in before] != [each.carrier for each in self.places]

    def settle(self) -> bool:
        """Release parts that have appeared on the floor; returns whether a disk changed."""
        known = self._lives.obstacles.standing
        down = [each for each in self.places if each.carrier and each.obstacle in known]
        for place in down:
            self._lives.roster.alter(place.carrier, radius=self._scenario.spec(place.carrier).radius)
            self._places[place.part] = PartPlace(place.part, place.obstacle)
        self._lives.roster.follow(self.places)
        return bool(down)

    def _take(self, robot: int, handles: Handling, at: Mapping[int, Vector]) -> None:
        place, radius = self._places[handles.part], self._scenario.loaded_radius(robot, handles.part)
        if handles.radius < radius or self.carried_by(robot):
            return
        if place.carrier:
            self._take_over(robot, place, at)
            return
        shape = self._lives.obstacles.standing.get(place.obstacle)
        if shape is not None and self._reaches(at[robot], self._scenario.spec(robot).radius, shape):
            self._lives.take_away(place.obstacle)
            self._load(robot, place)

    def _take_over(self, robot: int, place: PartPlace, at: Mapping[int, Vector]) -> None:
        if self._lives.roster.status(place.carrier) != "standing":
            return
        held = Disk(*at[place.carrier], self._scenario.loaded_radius(place.carrier, place.part))
        if self._reaches(at[robot], self._scenario.spec(robot).radius, held):
            self._withdraw(place)
            self._lives.unload(place.carrier, self._scenario.spec(place.carrier).radius)
            self._load(robot, place)

    def _load(self, robot: int, place: PartPlace) -> None:
        self._lives.roster.alter(robot, radius=self._scenario.loaded_radius(robot, place.part))
        self._places[place.part] = PartPlace(place.part, carrier=robot)

    def _put(self, place: PartPlace, handles: Handling | None, heard: bool, at: Mapping[int, Vector]) -> None:
        robot, spec = place.carrier, self._spec(place.part)
        radius = self._scenario.loaded_radius(robot, place.part)
        wanted = None if handles is None or handles.part != place.part else handles.place
        down = None if wanted is None else Disk(*wanted, spec.radius)
        fits = down is not None and self._reaches(at[robot], radius, down)
        if place.obstacle:
            if (heard and not fits) or self._lives.roster.status(robot) != "live":
                self._withdraw(place)
        elif down is not None and fits and self._is_free(down):
            self._places[place.part] = PartPlace(place.part, self._lives.announce(down), robot)

    def _withdraw(self, place: PartPlace) -> None:
        if place.obstacle:
            self._lives.take_away(place.obstacle)
            self._places[place.part] = PartPlace(place.part, carrier=place.carrier)

    def _reaches(self, centre: Vector, radius: float, shape: Shape) -> bool:
        """Whether a part is beside a robot, within the reach and outside its disk."""
        gap = shape.distance(*centre) - radius
        return -_ROUNDING <= gap <= self._scenario.carrying.reach + _ROUNDING

    def _is_free(self, down: Disk) -> bool:
        """Whether a part can be put down here: inside, and without present or announced overlaps."""
        obstacles = self._lives.obstacles
        others = (*obstacles.standing.values(), *obstacles.appearing.values())
        inside = self._scenario.workspace.shape.distance(down.x, down.y) + down.radius <= 0.0
        members = self._lives.roster.members
        stands = [(each.position, members[each.robot].radius) for each in self._lives.roster.standing]
        gaps = [shape.distance(down.x, down.y) for shape in others]
        gaps += [math.dist(position, (down.x, down.y)) - radius for position, radius in stands]
        return inside and all(gap >= down.radius for gap in gaps)

    def _spec(self, part: int) -> Part:
        return self._scenario.parts[part - 1]
