"""Lives: the process of each robot id, its scheduled faults, and its entry in the roster.

A robot id may have several lives. A life begins by joining and is numbered by its incarnation; it ends when
it is fenced, killed or followed by the next.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from typing import Final, TypeVar

from msgspec.structs import replace

from protocol.errors import JoinError
from protocol.geometry import Disk, Shape
from protocol.messages import LISTED, Command, Member, Standing, Vector
from protocol.scenario.model import ProcessFault, Scenario
from world.coordinator.keeper import Keeper
from world.coordinator.records import Life, LifeStatus, PastLives
from world.coordinator.roster import RosterDirectory

Item = TypeVar("Item")


_EVENTS: Final = {"kill": Life.kill, "pause": Life.pause, "resume": Life.resume, "restart": Life.restart}


class Lives:
    """The lives of all robots of a scenario.

    Args:
        returning: time for which a fenced robot may still return, s.
        past: of an earlier coordinator of this run: all its lives are over; numbers continue.
        tick: opened first.
    """

    def __init__(
        self, scenario: Scenario, returning: float = 0.0, past: PastLives | None = None, tick: int = 0
    ) -> None:
        if past is None:
            past = PastLives({robot: Life(0) for robot in scenario.ids})
        else:
            past = replace(past, of={robot: life.over(tick) for robot, life in past.of.items()})
        self.of = past.of
        self.fenced = past.fenced  # tick and disk of the first fencings, in order
        self.given_up = past.given_up  # tick, robot, incarnation, why
        self.roster = RosterDirectory(scenario, past.roster, past.numbered)
        self.founded = False  # whether the first tick has begun, or may
        self.keeper = Keeper(scenario, past.version)
        self.obstacles = self.roster.obstacles
        self._name = scenario.name
        self._silence = max(1, scenario.ticks(scenario.time.fence))
        self._returning = max(self._silence, scenario.ticks(returning))
        faults = sorted(scenario.process, key=lambda fault: fault.at)  # stable: as written, if at once
        self._faults = [(scenario.ticks(fault.at), fault) for fault in faults]
        self._over, self._skipped = past.faults, past.skipped

    @property
    def past(self) -> PastLives:
        return PastLives(
            self.of,
            self._over,
            self._skipped,
            self.fenced,
            self.given_up,
            self.roster.message,
            self.keeper.version,
            self.obstacles.numbered,
        )

    @property
    def applied(self) -> list[tuple[int, ProcessFault]]:
        """Tick and fault of each applied process fault."""
        skipped = set(self._skipped)
        return [each for n, each in enumerate(self._faults[: self._over]) if n not in skipped]

    @property
    def passed_over(self) -> tuple[tuple[int, int], ...]:
        """Tick and robot of each process fault without a disk."""
        return tuple((self._faults[n][0], self._faults[n][1].robot) for n in self._skipped)

    @property
    def incarnations(self) -> dict[int, int]:
        """Newest incarnation of every present or past robot; none is used twice."""
        return {robot: life.incarnation for robot, life in self.of.items()}

    @property
    def up(self) -> tuple[int, ...]:
        """Ids of active robots."""
        return tuple(robot for robot, life in self.of.items() if life.status is LifeStatus.UP)

    def found(
        self, radii: Mapping[int, float], places: Mapping[int, Vector], bounds: Mapping[int, float]
    ) -> None:
        """Begin the ledger, with the lives that have joined; disks of these radii are within `bounds` of
        `places`, m. A robot that has not joined is static.
        """
        roster, disks = self.roster, {}
        for robot, radius in sorted(radii.items()):
            life, bound = self.of[robot], bounds.get(robot, 0.0)
            disks[robot] = Disk(*places[robot], radius + bound)
            if life.joined:
                roster.put(Member(robot, life.incarnation, "live", radius))
            else:
                before = roster.members[robot].incarnation if robot in roster.members else 0
                roster.put(Member(robot, before, "standing", radius, places[robot], bound))
        self.founded = True
        self.keeper.found(disks, self.obstacles.standing)
        for member in roster.members.values():
            if member.status == "appearing" and member.position is not None:
                self.keeper.announce(member.robot, Disk(*member.position, member.radius))
        for number, shape in self.obstacles.appearing.items():
            self.keeper.announce(-number, shape)

    def begin(
        self, resting: Mapping[int, Vector], bounds: Mapping[int, float], unsettled: Set[int] = frozenset()
    ) -> str:
        """Begin joined lives in the ledger, once the earlier ones are over, and their disks are static at
        known places. Returns why the run cannot go on: a disk is not where the ledger has it; "" if it can.

        Args:
            resting: positions of robots that stand until they receive another command, m.
            bounds: errors of these, m, where there are any.
            unsettled: those of them that have not reported a position since they stand.
        """
        for robot, life in self.of.items():
            if not life.joined or life.fenced or life.begun or robot not in resting:
                continue
            if self.keeper.lives(robot):
                self.keeper.fence(robot, self._place(robot, resting, bounds))
            if robot in unsettled:
                continue
            place = self._place(robot, resting, bounds)
            reported = robot in bounds  # a simulation knows the places of its disks
            if reported and self.keeper.excludes(robot, place, self.roster.members[robot].radius):
                return f"robot {robot} is at ({place.x:.3f}, {place.y:.3f}), not where this run has its disk"
            self.keeper.settle(robot, place)
            self.keeper.rejoin(robot)
            life.begun = True
        return ""

    def _place(self, robot: int, resting: Mapping[int, Vector], bounds: Mapping[int, float]) -> Disk:
        return Disk(*resting[robot], self.roster.members[robot].radius + bounds.get(robot, 0.0))

    def announce(self, shape: Shape) -> int:
        """Announce an obstacle, which appears once all live robots keep clear of it; returns its number."""
        number = self.obstacles.announce(shape)
        self.keeper.announce(-number, shape)
        self.roster.follow()
        return number

    def take_away(self, number: int) -> bool:
        """Remove an obstacle or its announcement; returns whether there was one."""
        known = self.obstacles.take_away(number)
        if known:
            self.keeper.remove(-number)
        self.roster.follow()
        return known

    def settle(self) -> bool:
        """Let each announced obstacle appear that all robots keep clear of; returns whether any did. The
        roster follows with the parts that are among them."""
        settled = [number for number in self.obstacles.appearing if self.keeper.appear(-number)]
        for number in settled:
            self.obstacles.put_up(number)
        return bool(settled)

    def refuses(self, command: Command) -> bool:
        """Whether a Command refers to a roster or to grants that its life cannot have received."""
        return command.roster > self.roster.version or self.keeper.refuses(command)

    def on_command(self, command: Command) -> bool:
        """Record from a Command the roster that the newest life of a robot has received, and the grants that
        it obeys; False if a later one was recorded.
        """
        life = self.of[command.robot]
        if command.tick <= life.heard:
            return False
        life.heard = command.tick
        self.roster.acknowledge(command.robot, life.incarnation, command.roster)
        if life.begun:
            self.keeper.acknowledge(command)
        return True

    @property
    def newcomers(self) -> tuple[int, ...]:
        """Added robots whose disks are present, and whose processes may join."""
        of = self.of.items()
        return tuple(robot for robot, life in of if life.added and not (life.killed or life.paused))

    @property
    def awaited(self) -> frozenset[int]:
        """Ids that must join before the run continues."""
        return frozenset(robot for robot, life in self.of.items() if life.awaited)

    def join(self, robot: int, heard: int) -> int:
        """Begin a new life, active after tick `heard`; returns its incarnation. Raises JoinError for an
        unknown id, or one that is running, killed or paused.
        """
        life = self.of.get(robot)
        if life is None:
            known = ", ".join(map(str, self.of))
            raise JoinError(f"no robot {robot} in scenario {self._name!r}; there are {known}")
        if life.status is LifeStatus.UP:
            raise JoinError(f"robot {robot} is already running; stop it or use another id")
        if (member := self.roster.status(robot)) in ("appearing", "gone"):
            raise JoinError(f"robot {robot} is {member}: its disk is not in the workspace")
        if life.paused:
            raise JoinError(f"robot {robot} is paused by the scenario; wait for it to be resumed")
        life.incarnation += 1
        life.joined, life.awaited, life.fenced, life.begun, life.fate = True, False, False, False, ""
        life.added = False
        life.heard = life.before = heard
        if self.founded:
            admitted = {"incarnation": life.incarnation, "status": "live"}
            self.roster.alter(robot, **admitted, position=None, bound=0.0)
        life.status = LifeStatus.UP
        return life.incarnation

    def put_up(self, tick: int, robot: int, awaited: bool) -> None:
        """Let an announced disk appear as `tick` starts; the run waits for its process if `awaited`."""
        self.roster.alter(robot, status="standing")
        known = self.of.get(robot)
        incarnation = known.incarnation if known else 0
        life = Life(incarnation, LifeStatus.LOST, awaited=awaited, heard=tick, fenced=True, added=True)
        life.fate = "removed" if known else ""
        self.of = dict(sorted({**self.of, robot: life}.items()))

    def remove(self, tick: int, robot: int, position: Vector) -> None:
        """Remove a robot and its disk at the end of `tick`."""
        life = self.of[robot]
        if self.roster.status(robot) == "live":
            self._stand(tick, robot, position, 0.0)
        self.keeper.remove(robot)
        self.roster.alter(robot, status="gone", position=None, bound=0.0)
        life.status, life.awaited, life.fenced, life.added = LifeStatus.LOST, False, True, False
        life.fate = "removed"

    def unload(self, robot: int, radius: float) -> None:
        """Reduce the static disk of a robot to this radius, m: another robot has taken over its part."""
        member = self.roster.members[robot]
        self.roster.alter(robot, radius=radius)
        if member.position is not None:
            self.keeper.settle(robot, Disk(*member.position, radius + member.bound))

    def dismiss(self, robot: int) -> None:
        """Send no more Ticks to the notified process of a removed robot."""
        if self.roster.status(robot) in ("gone", "appearing"):
            self.of[robot].joined = False

    def _stand(self, tick: int, robot: int, position: Vector, bound: float) -> None:
        """End the present life of a robot: its disk is static within `bound` of `position`, m."""
        if self.keeper.lives(robot):
            self.keeper.fence(robot, self._place(robot, {robot: position}, {robot: bound}))
        if self.roster.status(robot) == "live":
            self.roster.alter(robot, status="standing", position=position, bound=bound)
        note(self.fenced, (tick + 1, Standing(robot, self.of[robot].incarnation, position)))

    def lose(self, tick: int, robot: int, reason: str) -> bool:
        """Record the failure of an active life's process, with a reason for the report; else False."""
        life = self.of[robot]
        if life.status is not LifeStatus.UP:
            return False
        life.status = LifeStatus.LOST
        self._report(tick, robot, reason)
        return True

    def expect(self, robot: int) -> bool:
        """Await the next life of a lost robot. False if it was ended by the scenario, or removed."""
        life = self.of[robot]
        life.awaited |= (lost := life.status is LifeStatus.LOST and not life.fate)
        return lost

    def give_up(self, tick: int, robot: int, reason: str) -> bool:
        """Continue without an awaited robot, which may still join later; otherwise as `lose`."""
        life = self.of[robot]
        if not life.awaited:
            return False
        life.awaited, life.status = False, LifeStatus.LOST
        self._report(tick, robot, reason)
        return True

    def _report(self, tick: int, robot: int, reason: str) -> None:
        if reason:
            note(self.given_up, (tick, robot, self.of[robot].incarnation, reason))

    def apply_faults(self, tick: int) -> None:
        """Apply the scenario's process faults up to and including `tick`, except to robots without a disk."""
        for n, (at, fault) in enumerate(self._faults[self._over :], self._over):
            if at > tick:
                break
            self._over += 1
            if self.roster.status(fault.robot) in ("live", "standing"):
                _EVENTS[fault.event](self.of[fault.robot])
            else:
                self._skipped.append(n)

    def fence(self, tick: int, robot: int, position: Vector, bound: float) -> None:
        """Fence a life within `bound` of `position`, m, if it has been silent too long after `tick`."""
        life = self.of[robot]
        if not life.fenced and tick - life.heard >= self._silence:
            life.fenced = True
            self._stand(tick, robot, position, bound)
            if life.status is LifeStatus.UP:
                life.status = LifeStatus.LOST

    def listeners(self) -> list[tuple[int, Life]]:
        """Incarnations whose processes may listen: active ones, and lost ones that are not yet informed."""
        may = (LifeStatus.UP, LifeStatus.LOST)
        return [(robot, life) for robot, life in self.of.items() if life.status in may and life.joined]

    def gone_for_good(self, tick: int) -> bool:
        """Whether no robot that is down can return.

        A fenced life whose process still runs is informed, and joins again: it has at least as long for that
        as the silence that fenced it.
        """
        kinds = ("resume", "restart")
        returning = {fault.robot for _, fault in self._faults[self._over :] if fault.event in kinds}
        over = self._silence + self._returning
        return all(
            life.fenced and tick - life.heard >= over and robot not in returning
            for robot, life in self.of.items()
            if life.status is not LifeStatus.UP
        )


def note(entries: list[Item], entry: Item) -> None:
    """Keep only the first `LISTED` of unlimited entries."""
    if len(entries) < LISTED:
        entries.append(entry)
