"""The world: true positions, what each robot is told of them, what its commands do, and the judge.

Sans-I/O: no clock, no socket; the caller says when robots joined, went, and when a tick is over.
One tick: `open_tick` (and `join` for whoever is awaited), `accept` commands, `close_tick`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import msgspec

from protocol.messages import Command, GoalStatus, Roster, Sense, Standing, Thing, Tick, Truth, Vector
from protocol.requests.goals import GoalOrder, GoalReply
from protocol.requests.things import ThingOrder, ThingReply
from protocol.scenario.model import RobotSpec, Scenario
from world.coordinator.commands import Commands
from world.coordinator.inputs import (
    Added,
    Closed,
    Ended,
    Expected,
    GivenUp,
    Halted,
    Input,
    Joined,
    Lost,
    Opened,
    Ordered,
    Placed,
    Removed,
    TakenAway,
    checksum,
)
from world.coordinator.lives import Lives
from world.coordinator.membership import Membership
from world.coordinator.missions import Missions
from world.coordinator.patience import blamed
from world.judge.goals import Goals
from world.judge.record import Record
from world.judge.touches import Touches
from world.judge.verdict import Judge
from world.plants.choice import plant_of
from world.plants.integrator import STANDING
from world.report import report
from world.sensing.odometry import Odometer
from world.sensing.position import Sensor


class World:
    """One run of a scenario.

    Attributes:
        tick: the tick that is open, or that is to be opened next.
        active: ids that take part in the tick opened last.
        verdict, reason: empty while the run goes on.
        halted: whether an emergency stop is in force.
        note: is told every input that this world has taken, in order, before the call that gave it returns.
            The same inputs given to another world of the same scenario make it the same
            (`world.shell.replay`).
    """

    def __init__(
        self, scenario: Scenario, incarnations: Mapping[int, int] | None = None, version: int = 0
    ) -> None:
        """Args:
        scenario: with the gain k a number.
        incarnations: last known incarnation by robot id, of earlier runs; 0 if absent.
        version: last known version of the roster, of earlier runs.
        """
        self.tick = 0
        self.active: tuple[int, ...] = ()
        self.verdict = ""
        self.reason = ""
        self.halted = False
        self.note: Callable[[Input], None] | None = None
        self._scenario = scenario
        self._plant = plant_of(scenario)
        self._odometers = {robot: Odometer(scenario, robot, self._plant.slips) for robot in scenario.ids}
        self._sensors = {robot: Sensor(scenario, robot) for robot in scenario.ids}
        self._lives = Lives(scenario, incarnations or {}, version)
        self._commands = Commands(self._lives)
        self._missions = Missions(scenario)
        goals = Goals(scenario)
        self._record = Record(scenario, goals, self._plant.positions, self._plant.parts)
        self._touches = Touches()
        self._judge = Judge(scenario, goals)
        self._told: dict[int, Tick] | None = None  # of the open tick
        self._membership = Membership(scenario, self._lives, self._missions)
        self._departed: dict[int, float] = {}  # path lengths of robots that left, m

    @property
    def truth(self) -> Truth:
        """Where every disk is at the start of `tick`."""
        return self._record.truth

    def news(self) -> list[Truth]:
        """The truth of every tick up to `tick` that was not handed out yet; each is handed out once."""
        return self._record.news()

    @property
    def checksum(self) -> int:
        """Of where every disk is, to the last bit."""
        return checksum(self._plant.positions)

    @property
    def is_open(self) -> bool:
        """Whether `tick` has begun."""
        return self._told is not None

    @property
    def incarnations(self) -> dict[int, int]:
        """Newest incarnation of every robot; a following run counts on from there."""
        return self._lives.incarnations

    @property
    def version(self) -> int:
        """Newest version of the roster; a following run counts on from there."""
        return self._lives.version

    @property
    def founded(self) -> bool:
        """Whether the first tick has begun, with all that were there."""
        return self._lives.founded

    @property
    def standing(self) -> tuple[Standing, ...]:
        """Fenced lives: fixed disks until that robot joins again."""
        return self._lives.standing

    @property
    def awaiting_join(self) -> frozenset[int]:
        """Robots that must be up at this tick, by the scenario, and have not joined."""
        return self._lives.awaited

    @property
    def waiting(self) -> frozenset[int]:
        """Active robots whose command of the open tick is outstanding."""
        return frozenset(self._commands.waiting)

    @property
    def missed(self) -> int:
        """Commands that never came, over all active robots and ticks."""
        return self._commands.missed

    @property
    def complete(self) -> bool:
        """Whether nobody is in `waiting`."""
        return not self._commands.waiting

    def join(self, robot: int) -> int:
        """A process takes over a robot; it takes part from the next opening of a tick on.

        Returns its incarnation.

        Raises:
            JoinError: unknown id, or an id that is running or held down by the scenario.
        """
        incarnation = self._lives.join(robot, heard=self.tick - 1 if self._told is None else self.tick)
        self._membership.joined(robot)
        self._noted(Joined(robot, incarnation))
        return incarnation

    def goes_on(self, robot: int, incarnation: int) -> bool:
        """Whether this life of a robot has joined this run and nothing has ended it."""
        return self._lives.goes_on(robot, incarnation)

    def is_paused(self, robot: int) -> bool:
        """Whether the scenario holds a robot's process still; it may join once it is resumed."""
        return self._lives.is_paused(robot)

    def lost(self, robot: int, reason: str = "") -> bool:
        """The robot's process is gone or given up on: it stands still and takes no part from now on.

        In an open tick, `open_tick` tells the others of it. False if it took no part anyway; else a
        `reason` stands in the report.
        """
        took_part = self._lives.lose(robot)
        if took_part and reason:
            self._lament(robot, reason)
        if robot in self.active:
            self._leave_out(robot)
        self._noted(Lost(robot, reason))
        return took_part

    def _lament(self, robot: int, reason: str) -> None:
        self._lives.given_up.append((self.tick, robot, self._lives.of[robot].incarnation, reason))

    def _leave_out(self, robot: int) -> None:
        self.active = tuple(other for other in self.active if other != robot)
        self._commands.drop(robot)
        if self._told is not None:
            replace = msgspec.structs.replace
            self._told = {other: replace(told, active=self.active) for other, told in self._told.items()}

    def expect(self, robot: int) -> None:
        """The process of a lost robot is being started again: it is in `awaiting_join` from now on."""
        self._lives.expect(robot)
        self._noted(Expected(robot))

    def give_up_waiting(self, robot: int, reason: str = "") -> bool:
        """Go on without a robot of `awaiting_join`; it may still join later. As `lost` otherwise."""
        awaited = self._lives.give_up(robot)
        if awaited and reason:
            self._lament(robot, reason)
        self._noted(GivenUp(robot, reason))
        return awaited

    def blamed(self) -> dict[int, str]:
        """Whom to give up in the open tick, which was told again, and why; their time begins anew."""
        lacking, self._commands.lacking = self._commands.lacking, {}
        return blamed(self.active, self._commands.waiting, lacking)

    def open_tick(self) -> dict[int, Tick]:
        """Begin the tick: what each robot that may listen is to be told. Idempotent until `close_tick`.

        The scenario's process faults of this tick happen first, those of the first tick once all are there:
        whatever the order of joining, everybody begins the run. While robots are awaited the tick does
        not begin: only those of them that have to learn that they were fenced are told.
        """
        if self._told is None:
            self._noted(Opened())
            if not self._begun():
                return {}
            self._lives.apply_faults(self.tick)
            awaited = self.awaiting_join
            if awaited:
                return {robot: told for robot, told in self._tell(self._lives.up).items() if robot in awaited}
            self.active = self._lives.up
            self._commands.open(self.tick, self.active)
            self._told = self._tell(self.active, self._sense())
        return self._told

    def _begun(self) -> bool:
        """Whether the run has begun, or begins now."""
        if not self.founded and not self.awaiting_join:
            self._lives.found(dict(zip(self._plant.ids, self._plant.positions, strict=True)))
        return self.founded

    def _sense(self) -> dict[int, Sense]:
        """Of every robot, those who do not listen included: sensors keep running."""
        sensed = {}
        for index, (robot, place) in enumerate(zip(self._plant.ids, self._plant.positions, strict=True)):
            sensor = self._sensors[robot]
            position, stamp = sensor.measure(self.tick, place)
            moved, bound, motion = self._odometers[robot].read(self._plant.report(index), self.tick)
            sensed[robot] = Sense(position, stamp, sensor.bound, moved, bound, motion)
        return sensed

    def _tell(
        self, active: tuple[int, ...], sensed: Mapping[int, Sense] = MappingProxyType({})
    ) -> dict[int, Tick]:
        """Ticks for all that may listen."""
        roster_for = self._lives.roster_for
        return {
            robot: Tick(
                robot,
                life.incarnation,
                self.tick,
                active,
                sensed.get(robot),
                roster_for(robot),
                self._missions.goal(robot),
                self.halted,
            )
            for robot, life in self._lives.listeners()
        }

    def order(self, robot: int, order: GoalOrder) -> GoalReply:
        """Send a robot elsewhere, from the next tick on that is opened; a refused order changes nothing."""
        refusal = self._missions.refusal(robot, order, self._lives.standing, self._lives.things.standing)
        if refusal:
            return GoalReply(False, text=refusal)
        position = self._plant.positions[self._plant.ids.index(robot)]
        reply = self._missions.accept(robot, order, self.tick, position)
        self._redirect(robot)
        self._noted(Ordered(robot, order))
        return reply

    def _redirect(self, robot: int) -> None:
        goal = self._missions.goal(robot)
        assert goal is not None
        self._record.redirect(robot, goal)
        self._judge.disturb(self.tick)

    def goal_status(self, robot: int) -> GoalStatus | None:
        """How things stand with a robot's goal; None if there is no such robot."""
        if robot not in self._plant.ids:
            return None
        status = self._missions.status(robot)
        if status.number == 0 and robot in self._judge.arrived(self._plant.positions):
            return msgspec.structs.replace(status, tick=self.tick, status="arrived")
        return status

    def goal_news(self) -> list[GoalStatus]:
        """What came of orders since this was last asked for."""
        return self._missions.news()

    @property
    def scenario(self) -> Scenario:
        """The scenario with the robots that are there now."""
        return self._scenario

    @property
    def roster(self) -> Roster:
        """Who is there."""
        return self._lives.roster

    @property
    def newcomers(self) -> tuple[int, ...]:
        """Robots that were added, whose disks are there, and whose processes have not joined yet."""
        return tuple(sorted(self._membership.newcomers))

    def add(self, spec: RobotSpec) -> str:
        """Have the disk of another robot appear at its start, once everybody keeps clear of that place.

        Returns why that cannot be; "" if it is under way.
        """
        reason = self._fixed or self._plant.refusal(spec) or self._membership.add(spec)
        if not reason:
            self._noted(Added(spec))
        return reason

    @property
    def _fixed(self) -> str:
        """Why nobody can come or go; "" if that is possible."""
        if not self.founded or self.verdict:
            return "the run has not begun, or is over"
        return self._plant.fixed

    def remove(self, robot: int) -> str:
        """End a robot and take its disk away, at the end of the open tick or else now.

        Returns why that cannot be; "" if it is done.
        """
        reason = self._fixed or self._membership.remove(robot)
        if reason:
            return reason
        if self._told is None:
            self._turn_over()
        self._noted(Removed(robot))
        return ""

    def dismiss(self, robot: int) -> bool:
        """Whether a robot was removed; its process, which asks, is told no more."""
        gone = self._lives.status_of(robot) == "gone"
        if gone and robot in self._lives.of:
            self._lives.dismiss(robot)
        return gone

    def _turn_over(self) -> None:
        """Between two ticks: who was added and may appear is there, who was removed is not."""
        plant = self._plant
        left = self._membership.turn_over(self.tick, dict(zip(plant.ids, plant.positions, strict=True)))
        if left is None:
            return
        self._departed |= {robot: plant.lengths[plant.ids.index(robot)] for robot in left}
        scenario = self._scenario = self._membership.scenario
        plant.recast(scenario)
        self._sensors = {robot: self._sensors.get(robot) or Sensor(scenario, robot) for robot in scenario.ids}
        self._odometers = {
            robot: self._odometers.get(robot) or Odometer(scenario, robot, plant.slips)
            for robot in scenario.ids
        }
        self._missions.recast(scenario)
        self._record.recast(scenario, plant.positions, self._lives.things.standing)
        self._lives.things.recast(scenario)
        self._judge.recast(scenario, self.tick)

    @property
    def things(self) -> tuple[Thing, ...]:
        """Things that came or went since the run began, as the roster has them."""
        return self._lives.things.changes

    def add_thing(self, order: ThingOrder) -> ThingReply:
        """Have a thing put up; a refused one changes nothing.

        It stands once every robot that takes part has acknowledged its place; none can be added before the
        first tick.
        """
        refusal = "" if self.founded else "the run has not begun"
        refusal = refusal or self._lives.things.refusal(order, self._plant.positions)
        if refusal:
            return ThingReply(False, text=refusal)
        number = self._lives.announce(order.shape)
        self._judge.disturb(self.tick)
        self._noted(Placed(order))
        return ThingReply(True, number, self._missions.covered(order.shape))

    def remove_thing(self, number: int) -> ThingReply:
        """A thing was taken out of the workspace, or is not to appear after all."""
        if not (self.founded and self._lives.take_away(number)):
            return ThingReply(False, text=f"there is no thing {number}")
        self._record.surround(self._lives.things.standing)
        self._judge.disturb(self.tick)
        self._noted(TakenAway(number))
        return ThingReply(True, number)

    def halt(self, halted: bool) -> None:
        """Have everybody stand, from the open tick on, or release them."""
        if halted != self.halted:
            self.halted = halted
            self._noted(Halted(halted))

    def accept(self, command: Command) -> bool:
        """Take a command if it is of the open tick, of an active life and the first; else count why not."""
        taken = self._commands.accept(command)
        if taken:
            self._noted(command)
        return taken

    def close_tick(self) -> None:
        """End the tick: move everything, judge, advance. Missing commands mean standing still."""
        if self._told is None:
            raise RuntimeError(f"tick {self.tick} is not open: call open_tick, and join for those awaited")
        self._commands.close()
        self._plant.move(self._obeyed(), self.tick)
        self._touches.add(self.tick, self._plant.touched())
        self._fence()
        self._told = None
        self.tick += 1
        self._record.add(self._plant.positions, self._plant.between)
        if self._lives.settle():
            self._record.surround(self._lives.things.standing)
        self._turn_over()
        self._decide()
        if self.note is not None:
            self.note(Closed(self.checksum))

    def _obeyed(self) -> dict[int, Vector]:
        """What the bases are told in this tick; while all are halted, to brake."""
        if self.halted:
            return dict.fromkeys(self._plant.ids, STANDING)
        commands = self._commands.velocities
        return {robot: self._odometers[robot].obeyed(commands[robot], self.tick) for robot in commands}

    def _fence(self) -> None:
        for index, (robot, position) in enumerate(zip(self._plant.ids, self._plant.positions, strict=True)):
            if robot not in self._commands.velocities and self._plant.stands(index):
                self._lives.fence(self.tick, robot, position)

    def _decide(self) -> None:
        if self.halted:
            self._judge.disturb(self.tick)
        for robot in self._missions.advance(self.tick, self._plant.ids, self._plant.positions):
            self._redirect(robot)
        if not self.verdict and not self._scenario.time.endless:
            up = self._lives.up
            alone = len(up) < len(self._plant.ids) and self._lives.gone_for_good(self.tick - 1)
            verdict, reason = self._judge.judge(
                self.tick, self._plant.positions, up, alone, pending=self._missions.pending
            )
            if verdict:
                self._finish(verdict, reason)

    def finish(self, verdict: str, reason: str) -> None:
        """End the run, e.g. as interrupted or aborted; a collision outranks, a second verdict is ignored."""
        if not self.verdict:
            self._finish(verdict, reason)
            self._noted(Ended(verdict, reason))

    def _noted(self, taken: Input) -> None:
        if self.note is not None:
            self.note(taken)

    def _finish(self, verdict: str, reason: str) -> None:
        touches = max(len(self._record.contacts.all), len(self._touches.all))
        if touches:
            verdict, reason = "collision", f"contacts: {touches}; otherwise {verdict}: {reason}"
        self.verdict, self.reason = verdict, reason

    def report(self) -> dict[str, Any]:
        """All that the world knows of the result, in plain types that JSON knows."""
        return report(
            self._scenario,
            verdict=(self.verdict, self.reason),
            arrived=self._judge.arrived(self._plant.positions),
            record=self._record,
            touches=self._touches,
            lengths=dict(zip(self._plant.ids, self._plant.lengths, strict=True)) | self._departed,
            commands=self._commands,
            lives=self._lives,
            sensors=self._sensors.values(),
        )
