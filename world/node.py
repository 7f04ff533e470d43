"""The world as a participant: admits robots, drives the clock, publishes what it judged.

Lock-step: a tick begins when every robot that takes part is there, and ends when each has commanded.
Real time: ticks end by the wall clock, whoever has commanded. All waits are bounded; a robot that is
not heard in time is given up (it stands still, and is fenced) and named.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from enum import Enum
from typing import Any

import msgspec

from protocol import joining
from protocol.bus import Bus, Event, Presence, Publish, Request
from protocol.codec import decode, encode
from protocol.errors import JoinError, MessageError
from protocol.keys import every_robot, parse, robot_key, world_key
from protocol.messages import Clock, Command, Measurement, Result
from protocol.scenario import Scenario
from protocol.steering import Steering, decode_steer
from protocol.streams import STREAMS
from world.roster import Roster
from world.traffic import traffic
from world.world import World

GATHERING = 20.0  # s that robots have to join
PATIENCE = 5.0  # s that a lock-step tick waits for a command
FAREWELL = 2.0  # s that robots have to report after the end, and to hear that it is over
BEAT = 0.1  # s between clocks while waiting


class Phase(Enum):
    """RUNNING (or gathering), FAREWELL (robots report), CLOSING (they are told to leave)."""

    RUNNING = 1
    FAREWELL = 2
    CLOSING = 3


class WorldNode:
    """One world, one scenario after another with the same robots, on one bus."""

    def __init__(
        self,
        bus: Bus,
        run: str,
        scenarios: Sequence[Scenario],
        lockstep: bool = True,
        *,
        gathering: float = GATHERING,
        patience: float = PATIENCE,
    ) -> None:
        self.reports: list[dict[str, Any]] = []
        self.finished = False
        self.steering = Steering()
        self._bus, self._run, self._lockstep = bus, run, lockstep
        self._gathering, self._patience = gathering, patience
        self._scenarios = iter(scenarios)
        self._roster = Roster(scenarios[0].ids)
        self._turn = -1
        self._begin(next(self._scenarios), {})
        self._declare()

    def _declare(self) -> None:
        bus, run = self._bus, self._run
        self._tell = {
            name: bus.publisher(STREAMS[name], world_key(run, name)) for name in ("clock", "truth", "result")
        }
        self._measure: dict[int, Publish] = {
            robot: bus.publisher(STREAMS["measurement"], robot_key(run, robot, "measurement"))
            for robot in self._roster.seats
        }
        bus.subscribe(every_robot(run, "command"))
        bus.watch(every_robot(run, "alive"))
        bus.serve(world_key(run, "control"))
        bus.serve(world_key(run, "scenario"))
        bus.announce(world_key(run, "alive"))

    def _begin(self, scenario: Scenario, incarnations: dict[int, int]) -> None:
        self._scenario = scenario
        self._turn += 1
        self._oldest = {robot: incarnations.get(robot, 0) + 1 for robot in scenario.ids}
        self.world = World(scenario, incarnations)
        self._roster.forget_reports()
        self._rejected: Counter[str] = Counter()
        self._received = self._published = 0
        self._phase = Phase.RUNNING
        self._opened = False
        self._since = self._began = time.monotonic()  # when the present wait began
        self.deadline = self._since + BEAT

    # -- events

    def handle(self, event: Event) -> None:
        if isinstance(event, Presence):
            self._on_presence(event)
        elif isinstance(event, Request):
            event.reply(self._reply(event))
            self._advance()
        else:
            self._on_command(event.key, event.payload)

    def _on_command(self, key: str, payload: bytes) -> None:
        try:
            message = decode(key, payload)
        except MessageError as error:
            self._rejected[error.reason] += 1
            return
        self._received += 1
        if isinstance(message, Command) and self.world.accept(message) and not self.world.waiting:
            self._advance()

    def _on_presence(self, event: Presence) -> None:
        robot = parse(event.key).robot
        if robot not in self._roster.seats:
            return
        if event.alive:
            self._roster.arrive(robot)
        else:
            self._roster.leave(robot)
            self._give_up([robot])
        self._advance()

    def _reply(self, request: Request) -> bytes:
        try:
            if parse(request.key).stream == "control":
                return self._steer(request.payload)
            if not request.payload:
                return joining.encode_reply(joining.Overview(self._scenario, self._lockstep))
            return joining.encode_reply(self._admit(joining.decode_request(request.payload)))
        except MessageError as error:
            self._rejected[error.reason] += 1
            return joining.encode_reply(joining.Refusal(str(error)))

    def _steer(self, payload: bytes) -> bytes:
        steer = decode_steer(payload)
        if self._lockstep:
            self.steering.apply(steer)
        return msgspec.msgpack.encode(self.steering)

    def _admit(self, join: joining.Join) -> joining.Reply:
        robot = join.robot
        if robot not in self._roster.seats:
            return joining.Refusal(
                f"robot {robot} is not in scenario {self._scenario.name!r} of run {self._run!r}"
            )
        if self._roster.occupied_by_another(robot, join.session):
            return joining.Refusal(
                f"robot {robot} is already running in run {self._run!r}; use another id or run"
            )
        seat = self._roster.seats[robot]
        if self._phase is Phase.FAREWELL:
            seat.health = join.health or seat.health
            self._farewell()
        if self._phase is Phase.FAREWELL:
            return joining.Wait(0.005, "the run is being wound up")
        if self._phase is Phase.CLOSING:
            seat.told = True
            return joining.Finished(self.world.verdict)
        if not self._roster.reserve(robot, join.session, time.monotonic()):
            return joining.Wait(0.2, f"another process is joining as robot {robot}")
        return self._enlist(robot)

    def _enlist(self, robot: int) -> joining.Reply:
        try:
            incarnation = self.world.join(robot)
        except JoinError as error:
            return joining.Refusal(str(error))
        return joining.Admission(incarnation, self._lockstep, self._scenario, self._turn, self._oldest)

    # -- the clock

    def wake(self, now: float) -> None:
        if self._phase is not Phase.RUNNING:
            self.deadline = now + BEAT
        elif self._lockstep or not self._opened:
            self._keep_waiting(now)
        else:
            self._close()
        self._advance()

    def _advance(self) -> None:
        """Do all that can be done now."""
        while self._phase is Phase.RUNNING:
            if not self._opened and not self._open():
                return
            if self.world.waiting or not self._lockstep:
                return
            self._close()
        if self._phase is Phase.FAREWELL:
            self._farewell()
        if self._phase is Phase.CLOSING:
            self._leave()

    def _open(self) -> bool:
        """Open the next tick, unless somebody who has to be there is not."""
        measurements = self.world.open_tick()
        if self._absent():
            if self._lockstep or self.world.tick == 0:
                self._remind(measurements)
                return False
            measurements = self._open_without()
        if not self._may_tick():
            return False
        self._opened = True
        if self.world.tick == 0:
            self._began = time.monotonic()
        self._schedule()
        self._announce()
        self._send(measurements)
        return True

    def _remind(self, measurements: dict[int, Measurement]) -> None:
        """A fenced life that the scenario wants back must learn that it has to join again."""
        self._send({robot: m for robot, m in measurements.items() if robot in self.world.awaiting_join})

    def _open_without(self) -> dict[int, Measurement]:
        """Real time waits for nobody; who comes later joins then."""
        for robot in self.world.awaiting_join:
            self.world.give_up_waiting(robot)
        return self.world.open_tick()

    def _may_tick(self) -> bool:
        now = time.monotonic()
        limited = self.steering.speed > 0.0 and not self.steering.paused  # steps are not held back
        if limited and self.world.tick > 0 and now < self._since + self._pause():
            self.deadline = self._since + self._pause()
            return False
        return self.steering.allow()

    def _pause(self) -> float:
        return self._scenario.time.step / self.steering.speed

    def _schedule(self) -> None:
        """When this tick ends by the wall clock (real time), or when to grow impatient (lock-step)."""
        now, step = time.monotonic(), self._scenario.time.step
        if self._lockstep:
            self._since, self.deadline = now, now + BEAT
        else:
            due = self._since + step if self.world.tick > 0 else now
            self._since = due if now < due + step else now
            self.deadline = self._since + step

    def _send(self, measurements: dict[int, Measurement]) -> None:
        for robot, measurement in measurements.items():
            self._measure[robot](encode(measurement))
        self._published += len(measurements)

    def _announce(self) -> None:
        world = self.world
        now = world.tick * self._scenario.time.step
        self._tell["clock"](encode(Clock(world.tick, now, world.active, world.down, world.verdict, self._turn)))

    def _close(self) -> None:
        truth = self.world.close_tick()
        self._opened = False
        self._tell["truth"](encode(truth))
        if self.world.verdict:
            self._end()

    def _keep_waiting(self, now: float) -> None:
        """Somebody is waited for: say so, and give up in time."""
        self.deadline = now + BEAT
        self._announce()
        if self.steering.paused or self.steering.speed > 0.0:
            self._since = now if self.steering.paused else self._since
        elif self._opened and now > self._since + self._patience:
            self._give_up(self.world.waiting)
        elif not self._opened and now > self._since + self._gathering:
            self._give_up_gathering()

    def _absent(self) -> frozenset[int]:
        """Robots that have to be there and are not: not joined, or joined without a token."""
        return self.world.awaiting_join | (self._roster.unseated() & frozenset(self.world.active))

    def _give_up_gathering(self) -> None:
        absent = sorted(self._absent())
        if self.world.tick == 0:
            names = ", ".join(map(str, absent))
            self.world.finish("aborted", f"no sign of robot {names} within {self._gathering:g} s")
            self._end()
        for robot in absent:
            self.world.give_up_waiting(robot)
            self.world.lost(robot)

    def _give_up(self, robots: Sequence[int] | frozenset[int]) -> None:
        """These do not take part any more; whoever waits for their states must know."""
        for robot in tuple(robots):
            self.world.lost(robot)
        if self._opened and self._lockstep:
            waiting = self.world.waiting
            self._send({r: m for r, m in self.world.open_tick().items() if r in waiting})

    # -- the end

    def interrupt(self, verdict: str, reason: str) -> None:
        """End everything from outside, for example on Ctrl-C; the report stays readable."""
        self._scenarios = iter(())
        if self._phase is Phase.RUNNING:
            self.world.finish(verdict, reason)
            self._end()
        self._conclude()
        self.finished = True

    def _end(self) -> None:
        self._phase, self._since = Phase.FAREWELL, time.monotonic()
        self.deadline = self._since + BEAT
        self._announce()

    def _farewell(self) -> None:
        """Wait for the robots' last reports, then publish the result and go on to the next run."""
        if not self._roster.owing_health() or time.monotonic() > self._since + FAREWELL:
            self._conclude()
        else:
            self._announce()

    def _conclude(self) -> None:
        if self._phase is not Phase.FAREWELL:
            return
        report = self.world.report()
        seats = self._roster.seats.values()
        report["messages"] = traffic(
            (s.health for s in seats), self._published, self._received, self._rejected
        )
        report["wall_time"] = self._since - self._began
        self.reports.append(report)
        self._tell["result"](encode(Result(msgspec.json.encode(report).decode())))
        following = next(self._scenarios, None)
        if following is None:
            self._phase, self._since = Phase.CLOSING, time.monotonic()
        else:
            self._begin(following, self.world.incarnations)

    def _leave(self) -> None:
        """Stay until everybody knows that it is over, or for so long."""
        if not self._roster.untold() or time.monotonic() > self._since + FAREWELL:
            self.finished = True
        else:
            self._announce()
