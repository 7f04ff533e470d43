"""The coordinator: opens and closes ticks, accepts Commands, manages membership, grants and orders.

It knows no plant, no sensor and no truth; its caller passes it the positions of disks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Set
from types import MappingProxyType

import msgspec

from protocol.messages import (
    Command,
    Count,
    GoalStatus,
    Sense,
    Summary,
    Tick,
    Vector,
)
from protocol.scenario.model import Scenario
from world.coordinator.commands import Commands, blamed
from world.coordinator.interest import Interest
from world.coordinator.lives import Lives, PastLives, note
from world.coordinator.membership import FleetChange, Membership
from world.coordinator.missions import Mission, Missions, Operated, Schedule
from world.coordinator.parts import Parts


class PastCoordinator(msgspec.Struct, frozen=True):
    """The state of a coordinator that its successor in the same run starts from."""

    tick: Count = 0  # that was open, or was to be opened next
    founded: bool = False
    stopped: bool = False
    lives: PastLives | None = None
    missions: list[tuple[Mission, GoalStatus]] = []
    fleet: FleetChange | None = None
    orders: list[str] = []  # of the scenario, that were carried out: see `Schedule`
    missed: Count = 0  # commands
    refused: dict[str, Count] = {}  # commands, by reason


class Coordinator:
    """Lives, commands, missions and membership of one run.

    Args:
        scenario: the run.
        returning: s for which a robot that was fenced may yet come back.
        past: of an earlier coordinator, which is no more; its tick is opened again.

    Attributes:
        tick: the tick that is open, or that is to be opened next.
        active: ids that take part in the tick opened last.
        stopped: whether an emergency stop was asked for.
        contested: whether another coordinator of this run is there.
        told: the Tick for each robot that may listen; None while no tick is open.
    """

    def __init__(
        self, scenario: Scenario, returning: float = 0.0, past: PastCoordinator = PastCoordinator()
    ) -> None:
        self.tick = past.tick
        self.active: tuple[int, ...] = ()
        self.stopped, self.contested = past.stopped, False
        self.told: dict[int, Tick] | None = None
        self.lives = Lives(scenario, returning, past.lives, past.tick)
        self.missions = Missions(scenario, past.missions)
        self.membership = Membership(scenario, self.lives, self.missions, past.fleet)
        self.parts = Parts(scenario, self.lives, self.lives.roster.message.parts)
        if self.membership.fleet.robots is not None:
            self.missions.recast(self.scenario)
            self.parts.recast(self.scenario)
        self.schedule = Schedule(scenario, past.orders)
        self.commands = Commands(self.lives, scenario.is_external)
        self.commands.missed, self.commands.refused = past.missed, Counter(past.refused)
        self._interest = Interest(scenario) if scenario.hears_near else None

    @property
    def past(self) -> PastCoordinator:
        """The state for a successor."""
        return PastCoordinator(
            self.tick,
            self.lives.founded,
            self.stopped,
            self.lives.past,
            self.missions.past,
            self.membership.fleet,
            self.schedule.past,
            self.commands.missed,
            self.commands.refused,
        )

    def found(self, places: Mapping[int, Vector], bounds: Mapping[int, float]) -> None:
        """Begin the ledger, with all disks within `bounds` of `places`, m."""
        radii = {spec.id: spec.radius for spec in self.parts.loaded(self.scenario).robots}
        self.lives.found(radii, places, bounds)

    @property
    def halted(self) -> bool:
        """Whether all robots are to stand."""
        return self.stopped or self.contested

    # -- membership

    @property
    def scenario(self) -> Scenario:
        """The scenario with the robots that are there now."""
        return self.membership.scenario

    @property
    def summary(self) -> Summary | None:
        """Recent positions of all robots, if this tick has to carry them."""
        return None if self._interest is None else self._interest.summary

    @property
    def newcomers(self) -> tuple[int, ...]:
        """Robots that were added, whose disks are there, and whose processes have not joined yet, and may."""
        of = self.lives.of
        return tuple(r for r in sorted(self.membership.fleet.newcomers) if not (of[r].killed or of[r].paused))

    @property
    def ended(self) -> tuple[int, ...]:
        """Robots whose newest processes the scenario has ended, or holds still."""
        of = self.lives.of.items()
        return tuple(robot for robot, life in of if life.fate == "ended" or life.killed or life.paused)

    # -- joining and leaving

    def join(self, robot: int) -> int:
        """A process takes over a robot; it takes part from the next opening of a tick on.

        Returns its incarnation.

        Raises:
            JoinError: unknown id, or an id that is running or held down by the scenario.
        """
        incarnation = self.lives.join(robot, heard=self.tick - 1 if self.told is None else self.tick)
        self.membership.fleet.newcomers.discard(robot)
        return incarnation

    def lost(self, robot: int, reason: str = "") -> bool:
        """The robot's process is gone or given up on: it stands still and takes no part from now on.

        In an open tick, `told` tells the others of it. False if it took no part anyway; else a `reason`
        stands in the report.
        """
        took_part = self.lives.lose(robot)
        if took_part and reason:
            self._lament(robot, reason)
        if robot in self.active:
            self._leave_out(robot)
        return took_part

    def expect(self, robot: int) -> bool:
        """The process of a lost robot is being started again: it is in `lives.awaited` from now on. False if
        it was not lost."""
        return self.lives.expect(robot)

    def give_up_waiting(self, robot: int, reason: str = "") -> bool:
        """Go on without a robot of `lives.awaited`; it may still join later. As `lost` otherwise."""
        awaited = self.lives.give_up(robot)
        if awaited and reason:
            self._lament(robot, reason)
        return awaited

    def dismiss(self, robot: int) -> None:
        """The process of a removed robot was notified: send it no more Ticks."""
        if robot in self.lives.of and self.lives.roster.status(robot) in ("gone", "appearing"):
            self.lives.of[robot].joined = False

    def _lament(self, robot: int, reason: str) -> None:
        note(self.lives.given_up, (self.tick, robot, self.lives.of[robot].incarnation, reason))

    def _leave_out(self, robot: int) -> None:
        self.active = tuple(other for other in self.active if other != robot)
        self.commands.drop(robot)
        if self.told is not None:
            self.told = {other: self._without(robot, told) for other, told in self.told.items()}

    def _without(self, robot: int, told: Tick) -> Tick:
        """The same, but for a robot that takes no part any more."""
        if robot not in told.active:
            return told
        return msgspec.structs.replace(told, active=tuple([each for each in told.active if each != robot]))

    # -- a tick

    @property
    def waiting(self) -> Set[int]:
        """Active robots whose command of the open tick is outstanding, as commands come in."""
        return self.commands.waiting  # asked for at each command: a copy would cost the square of the fleet

    def blamed(self) -> dict[int, str]:
        """Robots to give up in the open tick, with reasons; clears the reports of missing States."""
        lacking, self.commands.lacking = self.commands.lacking, {}
        told = self.told or {}
        heard_by = Counter(peer for robot in self.active for peer in told[robot].active)
        return blamed(heard_by, self.commands.waiting, lacking)

    def opens(self, places: Mapping[int, Vector], bounds: Mapping[int, float], operated: Operated) -> bool:
        """Whether the tick begins: the scenario's orders and process faults happen, and no robot is awaited.

        Args:
            places: of all disks, m.
            bounds: by how much these may be off as a run begins, m, where they may.
            operated: carries out orders.
        """
        if not self.lives.founded and not self.lives.awaited:
            self.found(places, bounds)
        if not self.lives.founded:
            return False
        self.schedule.carry_out(self.tick, operated)
        self.lives.apply_faults(self.tick)
        return not self.lives.awaited

    def tell_fenced(self) -> dict[int, Tick]:
        """Ticks that inform awaited robots of their fencing. They bypass `Interest`, whose state must not
        depend on how often these are sent. A live incarnation receives nothing before the tick opens: its
        last Command is not settled yet."""
        of = self.lives.of
        awaited = self.lives.awaited if self.lives.founded else frozenset()
        fenced = [robot for robot in awaited if of[robot].fenced]
        return {robot: told for robot, told in self._tell(self.lives.up).items() if robot in fenced}

    def open(
        self,
        sensed: Mapping[int, Sense],
        resting: Mapping[int, Vector],
        bounds: Mapping[int, float] = MappingProxyType({}),
        unsettled: Set[int] = frozenset(),
    ) -> dict[int, Tick]:
        """Begin the tick; `told` has its Ticks.

        Args:
            sensed: measurement and odometry of every robot.
            resting: robots that do not move until they hear another command, and where they are, m.
            bounds: by how much that may be off, m, where it may.
            unsettled: those of them that have not reported where they stand since they do.
        """
        self.active = self.lives.up
        self.commands.open(self.tick, self.active)
        self.lives.begin(resting, bounds, unsettled)
        if self._interest is not None:
            self._interest.open(self.tick, self.scenario, sensed, self.missions.goal)
        self.lives.keeper.advance({} if self._interest is None else self._interest.places)
        self.told = self._tell(self.active, sensed, self._interest)
        return self.told

    def accept(self, command: Command) -> bool:
        """Take a command if it is of the open tick, of an active life and the first; else count why not."""
        taken = self.commands.accept(command)
        if taken and self._interest is not None:
            self._interest.accept(command)
        return taken

    def close(
        self, resting: Mapping[int, Vector], bounds: Mapping[int, float] = MappingProxyType({})
    ) -> None:
        """End the tick. Fence each robot without a Command that has been silent for `time.fence`.

        Args:
            resting: robots that do not move until they hear another command, and where they are, m.
            bounds: by how much that may be off, m, where it may.
        """
        for robot, position in resting.items():
            if robot not in self.commands.taken:
                self.lives.fence(self.tick, robot, position, bounds.get(robot, 0.0))
        self.told = None
        self.tick += 1

    @property
    def pending(self) -> str:
        """Unfinished orders, scheduled orders and parts, as text; "" if none."""
        kinds = (
            (self.missions.pending, "orders are under way"),
            (self.membership.pending, "robots are still to appear"),
            (self.schedule.pending, "orders are still to come"),
            (self.parts.pending, "parts are not at their goals"),
        )
        return ", ".join(text for pending, text in kinds if pending)

    def is_alone(self) -> bool:
        """Whether robots are missing for good; False for external bases, which may return at any time."""
        if self.scenario.is_external:
            return False
        missing = len(self.lives.up) < len(self.scenario.ids) and not self.schedule.pending
        return missing and self.lives.gone_for_good(self.tick - 1)

    def _tell(
        self,
        active: tuple[int, ...],
        sensed: Mapping[int, Sense] = MappingProxyType({}),
        interest: Interest | None = None,
    ) -> dict[int, Tick]:
        """Ticks for all that may listen."""
        lives, goal, since = self.lives, self.missions.goal, self.missions.since
        present, bound = frozenset(active), self.lives.keeper.bound
        leased = self.scenario.is_external
        return {
            robot: Tick(
                robot,
                life.incarnation,
                self.tick,
                active
                if interest is None
                else interest.heard(robot, life.incarnation, self.tick, bound(robot), present),
                sense=sensed.get(robot),
                roster=lives.roster.news(robot),
                goal=goal(robot) if life.is_new or life.heard < since(robot) else None,
                halted=self.halted,
                heard=life.heard if leased and life.heard >= 0 else None,
                grants=lives.grants_for(robot),
            )
            for robot, life in lives.listeners()
        }
