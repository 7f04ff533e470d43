"""What stands in the workspace and is no robot: what the scenario lists, and what comes and goes while the
fleet runs. It comes as a robot's disk does, once all keep clear of its place, and goes once it was taken
away."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from protocol.geometry import Disk, Shape
from protocol.messages import PlacedObstacle, Presence, Vector
from protocol.scenario import model
from protocol.scenario.model import Scenario

MOST = 256  # obstacles that came, at a time: a roster is one message
MOST_CORNERS = 4096  # of all of them together


class Surroundings:
    """The obstacles of one run.

    Attributes:
        standing: shapes, by number.
        appearing: shapes that are announced, by number; nothing is there yet.
        numbered: how many there have been.

    Args:
        changes: up to now, as a roster said them.
        numbered: how many there have been, with those of the scenario at least.
    """

    def __init__(self, scenario: Scenario, changes: Iterable[PlacedObstacle] = (), numbered: int = 0) -> None:
        self._room, self._scenario = scenario.workspace.shape, scenario
        self._listed = scenario.shapes
        self.standing: dict[int, Shape] = dict(self._listed)
        self.appearing: dict[int, Shape] = {}
        self.numbered = max(numbered, len(self._listed))
        for change in changes:
            if change.status == "gone":
                self.standing.pop(change.number, None)
            else:
                known = self.appearing if change.status == "appearing" else self.standing
                known[change.number] = change.shape

    @property
    def changes(self) -> tuple[PlacedObstacle, ...]:
        """What a roster says of obstacles: all but those of the scenario that still stand."""
        came = {number: _obstacle(number, "appearing", shape) for number, shape in self.appearing.items()}
        for number, shape in self.standing.items():
            if number not in self._listed:
                came[number] = _obstacle(number, "standing", shape)
        for number in self._listed.keys() - self.standing.keys():
            came[number] = PlacedObstacle(number, "gone")
        return tuple(came[number] for number in sorted(came))

    def recast(self, scenario: Scenario) -> None:
        """Robots came and went."""
        self._scenario = scenario

    def refusal(self, order: model.Obstacle, positions: Sequence[Vector]) -> str:
        """Why an obstacle cannot come; "" if it can.

        Args:
            positions: of all disks in the order of robot ids, m.
        """
        if problem := order.defect():
            return f"the obstacle {problem}"
        shape = order.shape
        came = [each for each in self.changes if each.status != "gone"]
        if len(came) >= MOST:
            return f"at most {MOST} obstacles that came while the run went on are there at a time"
        if sum(len(each.points) for each in came) + len(order.points or ()) > MOST_CORNERS:
            return f"obstacles that came while the run went on have at most {MOST_CORNERS} corners together"
        if self._room.distance(shape.around.x, shape.around.y) >= shape.around.radius:
            return "the obstacle lies outside of the workspace"
        for robot, position in zip(self._scenario.ids, positions, strict=True):
            depth = self._scenario.spec(robot).radius - shape.distance(*position)
            if depth >= 0.0:
                return f"the obstacle overlaps robot {robot} by {depth:.3g} m"
        return ""

    def announce(self, shape: Shape) -> int:
        """Something is to appear; its number."""
        self.numbered += 1
        self.appearing[self.numbered] = shape
        return self.numbered

    def take_away(self, number: int) -> bool:
        """Something is gone, or does not appear after all; whether it was there."""
        known = number in self.standing or number in self.appearing
        self.standing.pop(number, None)
        self.appearing.pop(number, None)
        return known

    def put_up(self, number: int) -> None:
        """What was announced stands."""
        self.standing[number] = self.appearing.pop(number)


def present(listed: Mapping[int, Shape], changes: Iterable[PlacedObstacle]) -> tuple[PlacedObstacle, ...]:
    """All that stands or is to appear, if a scenario lists these shapes and a roster says these changes."""
    obstacles = {number: _obstacle(number, "standing", shape) for number, shape in listed.items()}
    obstacles |= {change.number: change for change in changes}
    return tuple(obstacles[number] for number in sorted(obstacles) if obstacles[number].status != "gone")


def _obstacle(number: int, status: Presence, shape: Shape) -> PlacedObstacle:
    if isinstance(shape, Disk):
        return PlacedObstacle(number, status, ((shape.x, shape.y),), shape.radius)
    return PlacedObstacle(number, status, shape.points)
