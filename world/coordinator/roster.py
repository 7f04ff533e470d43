"""The roster: a directory of all robots that ever were in the run, of obstacles that came or went, of parts.

It says what is there, for laws, carriers and monitors; its versions only grow. What robots obey the ledger
says.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from msgspec.structs import replace
from mypy_extensions import mypyc_attr

from protocol import messages
from protocol.errors import RosterError
from protocol.messages import Member, PartPlace, PlacedObstacle, Vector


@mypyc_attr(allow_interpreted_subclasses=True)
class Roster:
    """The coordinator's roster.

    Args:
        past: the newest of an earlier coordinator of the same run.

    Attributes:
        version: of the present one; 0 before the run is founded for the first time.
        founded: whether the first tick of this coordinator has begun, or may.
    """

    def __init__(self, past: messages.Roster | None = None) -> None:
        past = messages.Roster(0, ()) if past is None else past
        self.version, self.founded = past.version, False
        self._members = {each.robot: each for each in past.members}
        self._heard: dict[int, tuple[int, int]] = {}  # life and version that it has heard, by robot
        self._newest: messages.Roster | None = None
        self._obstacles, self._parts = past.obstacles, past.parts

    @property
    def standing(self) -> tuple[Member, ...]:
        """The disks that never move again in their present life."""
        return tuple(each for each in self._members.values() if each.status == "standing")

    @property
    def appearing(self) -> tuple[Member, ...]:
        """The disks that are announced."""
        return tuple(each for each in self._members.values() if each.status == "appearing")

    @property
    def ids(self) -> int:
        """How many ids it names, those that are gone included."""
        return len(self._members)

    def status(self, robot: int) -> str:
        """Of the disk of a robot; "" if no robot ever had that id."""
        member = self._members.get(robot)
        return "" if member is None else member.status

    def is_live(self, robot: int) -> bool:
        """Whether the disk of a robot may move."""
        return robot in self._members and self._members[robot].status == "live"

    def found(
        self,
        lives: Mapping[int, int],
        places: Mapping[int, Vector],
        radii: Mapping[int, float],
        bounds: Mapping[int, float] = MappingProxyType({}),
    ) -> None:
        """Begin the run, or go on with it as another coordinator: a robot that is not there by then stands.

        Args:
            lives: incarnation of every robot that is there.
            places: where the disk of every robot of the fleet is, m.
            radii: of every robot of the fleet, m.
            bounds: by how much places may be off, m, where they may.
        """
        for robot in sorted(radii):
            if life := lives.get(robot, 0):
                self._members[robot] = Member(robot, life, "live", radii[robot])
            else:
                before = self._members[robot].incarnation if robot in self._members else 0
                place, bound = places[robot], bounds.get(robot, 0.0)
                self._members[robot] = Member(robot, before, "standing", radii[robot], place, bound)
        self.founded = True
        self.version += 1

    def admit(self, robot: int, incarnation: int) -> None:
        """A later life of a robot takes part from now on.

        Raises:
            RosterError: its disk is not in the workspace, or the life is not a new one.
        """
        member = self._member(robot)
        if member.status not in ("live", "standing"):
            raise RosterError(f"robot {robot} cannot be admitted: its disk is {member.status}")
        if incarnation <= member.incarnation:
            raise RosterError(f"robot {robot}: life {incarnation} is not newer than {member.incarnation}")
        self._put(replace(member, incarnation=incarnation, status="live", position=None, bound=0.0))

    def fence(self, robot: int, position: Vector, bound: float = 0.0) -> None:
        """The present life of a live robot is over, its disk stands within `bound` of `position`, m."""
        member = self._member(robot)
        if member.status != "live":
            raise RosterError(f"robot {robot} cannot be fenced: its disk is {member.status}")
        self._put(replace(member, status="standing", position=position, bound=bound))

    def announce(self, robot: int, radius: float, position: Vector, bound: float = 0.0) -> None:
        """A disk is to appear; nothing is there until `put_up` says so.

        Raises:
            RosterError: the robot is in the workspace already.
        """
        known = self._members.get(robot)
        if known is not None and known.status != "gone":
            raise RosterError(f"robot {robot} cannot appear: its disk is {known.status}")
        life = 0 if known is None else known.incarnation
        self._put(Member(robot, life, "appearing", radius, position, bound))

    def withdraw(self, robot: int) -> None:
        """What was announced does not appear."""
        if self._member(robot).status != "appearing":
            raise RosterError(f"robot {robot} was not announced")
        self._put(replace(self._members[robot], status="gone", position=None, bound=0.0))

    def remove(self, robot: int) -> None:
        """A standing disk was taken out of the workspace.

        Raises:
            RosterError: it was not fenced.
        """
        member = self._member(robot)
        if member.status != "standing":
            raise RosterError(f"robot {robot} cannot be removed: its disk is {member.status}; fence it first")
        self._put(replace(member, status="gone", position=None, bound=0.0))

    def acknowledge(self, robot: int, incarnation: int, version: int) -> None:
        """A life has heard a version."""
        if (incarnation, version) > self._heard.get(robot, (0, 0)) and version <= self.version:
            self._heard[robot] = (incarnation, version)

    def put_up(self, robot: int) -> None:
        """A disk that was announced is in its place, and stands from here on."""
        self._put(replace(self._member(robot), status="standing"))

    def follow_obstacles(self, obstacles: tuple[PlacedObstacle, ...]) -> None:
        """Things came, are to come, or went: say so in a new version, once the run is founded."""
        if obstacles != self._obstacles:
            self._obstacles = obstacles
            self.version += 1

    def follow_parts(self, parts: tuple[PartPlace, ...]) -> None:
        """Parts are elsewhere: say so in a new version, once the run is founded."""
        if parts != self._parts:
            self._parts = parts
            self.version += 1

    def resize(self, robot: int, radius: float) -> None:
        """The disk of a robot that is there has another radius, m."""
        member = self._member(robot)
        if member.status not in ("live", "standing"):
            raise RosterError(f"robot {robot} cannot change its size: its disk is {member.status}")
        self._put(replace(member, radius=radius))

    def radius(self, robot: int) -> float:
        """Of the disk of a robot, m."""
        return self._member(robot).radius

    def news(self, robot: int) -> messages.Roster | None:
        """The roster, if the newest life of `robot` has not heard it."""
        member = self._members.get(robot)
        if member is not None and self._heard.get(robot) == (member.incarnation, self.version):
            return None
        return self.message

    @property
    def message(self) -> messages.Roster:
        """The present version."""
        if self._newest is None or self._newest.version != self.version:
            members = tuple(self._members[robot] for robot in sorted(self._members))
            self._newest = messages.Roster(self.version, members, self._obstacles, self._parts)
        return self._newest

    def _member(self, robot: int) -> Member:
        if robot not in self._members:
            raise RosterError(f"no robot {robot} in the roster; there are {_names(self._members)}")
        return self._members[robot]

    def _put(self, member: Member) -> None:
        self._members[member.robot] = member
        self.version += 1


def _names(robots: Iterable[int]) -> str:
    return ", ".join(map(str, sorted(robots))) or "none"
