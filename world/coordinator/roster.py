"""The roster: a directory of all robots of the run, past and present, of changed obstacles, and of parts.

It serves laws, carriers and monitors; its versions only increase. The constraints of robots are in the
ledger.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from msgspec.structs import replace

from protocol import messages
from protocol.geometry import Shape, points_of
from protocol.messages import Member, PartPlace, PlacedObstacle, Standing, Vector
from protocol.scenario import model
from protocol.scenario.model import Scenario

MOST = 256  # added obstacles at a time, limited by the size of a roster
MOST_CORNERS = 4096  # of all of these together


class Surroundings:
    """The obstacles of one run: those of the scenario, and added or removed ones.

    `changes` are those so far, as in a roster.
    """

    def __init__(self, scenario: Scenario, changes: Iterable[PlacedObstacle] = (), numbered: int = 0) -> None:
        self._room = scenario.workspace.shape
        self._listed = scenario.shapes
        self.standing: dict[int, Shape] = dict(self._listed)  # by number
        self.appearing: dict[int, Shape] = {}  # announced, by number; none is present yet
        self.numbered = max(numbered, len(self._listed))  # all obstacles so far
        for change in changes:
            if change.status == "gone":
                self.standing.pop(change.number, None)
            else:
                known = self.appearing if change.status == "appearing" else self.standing
                known[change.number] = change.shape

    @property
    def changes(self) -> tuple[PlacedObstacle, ...]:
        """Entries of obstacles for a roster: all but present ones of the scenario."""
        gone = sorted(self._listed.keys() - self.standing.keys())  # the lower numbers
        return (*(PlacedObstacle(number, "gone") for number in gone), *self._there(self._listed))

    @property
    def present(self) -> tuple[PlacedObstacle, ...]:
        """Shapes that are present or announced."""
        return self._there({})

    def _there(self, besides: Mapping[int, Shape]) -> tuple[PlacedObstacle, ...]:
        there = {number: self.standing[number] for number in self.standing.keys() - besides.keys()}
        return tuple(
            PlacedObstacle(number, "appearing" if number in self.appearing else "standing", *points_of(shape))
            for number, shape in sorted((there | self.appearing).items())
        )

    def refusal(self, order: model.Obstacle, scenario: Scenario, positions: Sequence[Vector]) -> str:
        """The reason why an obstacle is refused, with disks at `positions`, m, by id; "" if it is not."""
        if problem := order.defect():
            return f"the obstacle {problem}"
        shape = order.shape
        came = self._there(self._listed)
        if len(came) >= MOST:
            return f"at most {MOST} added obstacles can be present at a time"
        if sum(len(each.points) for each in came) + len(order.points or ()) > MOST_CORNERS:
            return f"added obstacles can have at most {MOST_CORNERS} corners together"
        if self._room.distance(shape.around.x, shape.around.y) >= shape.around.radius:
            return "the obstacle lies outside of the workspace"
        for robot, position in zip(scenario.ids, positions, strict=True):
            depth = scenario.spec(robot).radius - shape.distance(*position)
            if depth >= 0.0:
                return f"the obstacle overlaps robot {robot} by {depth:.3g} m"
        return ""

    def announce(self, shape: Shape) -> int:
        """Announce an obstacle; returns its number."""
        self.numbered += 1
        self.appearing[self.numbered] = shape
        return self.numbered

    def take_away(self, number: int) -> bool:
        """Remove an obstacle or its announcement; returns whether there was one."""
        known = number in self.standing or number in self.appearing
        self.standing.pop(number, None)
        self.appearing.pop(number, None)
        return known

    def put_up(self, number: int) -> None:
        """Let an announced obstacle appear."""
        self.standing[number] = self.appearing.pop(number)


class RosterDirectory:
    """The coordinator's roster; `past` is the newest of an earlier coordinator of the same run."""

    def __init__(
        self, scenario: Scenario, past: messages.Roster = messages.Roster(0, ()), numbered: int = 0
    ) -> None:
        self.version = past.version  # of the present one; 0 before anything is in it
        self.members = {each.robot: each for each in past.members}
        self.obstacles = Surroundings(scenario, past.obstacles, numbered)
        self._changes, self._parts = past.obstacles, past.parts
        self._heard: dict[int, tuple[int, int]] = {}  # life and version received, by robot
        self._newest: messages.Roster | None = None

    @property
    def standing(self) -> tuple[Standing, ...]:
        """Static disks, with the lives that ended there."""
        return tuple(
            Standing(each.robot, each.incarnation, each.position)
            for each in self.members.values()
            if each.status == "standing" and each.position is not None
        )

    def status(self, robot: int) -> str:
        """Status of the disk of a robot; "" for an unknown id."""
        member = self.members.get(robot)
        return "" if member is None else member.status

    def put(self, member: Member) -> None:
        """Replace the entry of a robot."""
        self.members[member.robot] = member
        self.version += 1

    def alter(self, robot: int, **changes: Any) -> None:
        """Change fields of a robot's entry."""
        self.put(replace(self.members[robot], **changes))

    def follow(self, parts: tuple[PartPlace, ...] | None = None) -> None:
        """Make a new version if obstacles or parts have changed."""
        present = self.obstacles.changes, self._parts if parts is None else parts
        if present != (self._changes, self._parts):
            self._changes, self._parts = present
            self.version += 1

    def acknowledge(self, robot: int, incarnation: int, version: int) -> None:
        """Record that a life has received a version."""
        if (incarnation, version) > self._heard.get(robot, (0, 0)) and version <= self.version:
            self._heard[robot] = (incarnation, version)

    def news(self, robot: int) -> messages.Roster | None:
        """The roster, if the newest life of `robot` has not received it; otherwise None."""
        member = self.members.get(robot)
        if member is not None and self._heard.get(robot) == (member.incarnation, self.version):
            return None
        return self.message

    @property
    def message(self) -> messages.Roster:
        """The present version."""
        if self._newest is None or self._newest.version != self.version:
            members = tuple(self.members[robot] for robot in sorted(self.members))
            self._newest = messages.Roster(self.version, members, self._changes, self._parts)
        return self._newest
