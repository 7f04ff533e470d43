"""The world as a participant: admits robots, drives the clock, publishes what it judged.

Lock-step: a tick begins when every robot that takes part is there, and ends when each has commanded.
Real time: ticks end by the wall clock, whoever has commanded. All waits are bounded; a robot that is
not heard in time is given up (it stands still, and is fenced) and named; before that the tick is told
to all again, for a message may have been lost with a link, and they say whom they wait for (`patience`).
With a journal the node goes on where another one died: the tick that was open then is told again.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import Any

import msgspec

from protocol import joining
from protocol.bus.bus import Bus
from protocol.bus.events import Event, Presence, Request, Sample
from protocol.codec import decode
from protocol.errors import KeyGrammarError, MessageError
from protocol.keys import every_robot, parse, robot_key, world_key
from protocol.messages import Command, Measurement
from protocol.scenario.model import Scenario
from protocol.steering import decode_steer
from world.shell.admission import Admissions
from world.shell.journal import Began
from world.shell.pacing import Pacing
from world.shell.publishers import Publishers
from world.shell.replay import Resumed
from world.shell.turn import Turn

GATHERING = 20.0  # s that robots have to join
PATIENCE = 5.0  # s that a lock-step tick waits for a command
GRACE = 5.0  # s that a robot's token may be missing in a run whose processes are started again
SHUTDOWN = 2.0  # s that robots have to report after the end, and to hear that it is over
_ASK_AGAIN = 0.005  # s, for robots that have reported while others have not


class Phase(Enum):
    """RUNNING (or gathering), SHUTDOWN (robots report), CLOSING (they are told to leave)."""

    RUNNING = 1
    SHUTDOWN = 2
    CLOSING = 3


class WorldNode:
    """One world, one scenario after another with the same robots, on one bus.

    Args:
        bus: a connection of its own.
        run: name of the run.
        scenarios: all with the same robot ids; k already numbers.
        lockstep: whether ticks wait for the robots.
        gathering: s that robots have to join.
        patience: s that a lock-step tick waits for a command.
        speed: simulated seconds per second that lock-step is held to, 0 for no limit.
        restarts: how many times a robot whose process ends is started again; lock-step waits for it.
        clock: tells the time, s; for tests.
        say: takes what a person should know.
        past: where to go on. What has to outlive this process is noted in its journal; whoever is missing
            may come back within GRACE, unless another process takes its seat: when a router dies, all
            tokens go, and come back.
        tell: is told every report.

    Attributes:
        reports: one a scenario that has ended, as far as this process saw it.
    """

    def __init__(
        self,
        bus: Bus,
        run: str,
        scenarios: Sequence[Scenario],
        lockstep: bool = True,
        *,
        gathering: float = GATHERING,
        patience: float = PATIENCE,
        speed: float = 0.0,
        restarts: int = 0,
        clock: Callable[[], float] = time.monotonic,
        say: Callable[[str], None] = lambda _: None,
        past: Resumed | None = None,
        tell: Callable[[dict[str, Any]], None] = lambda _: None,
    ) -> None:
        self._say = say
        self.reports: list[dict[str, Any]] = []
        self.finished = False
        self._pacing = Pacing(lockstep, speed, clock)
        self._lockstep, self._gathering, self._patience = lockstep, gathering, patience
        self._grace = 0.0 if past is None else GRACE
        self._journal = None if past is None else past.journal
        self._tell = tell
        self._expected = dict.fromkeys(scenarios[0].ids, 0)  # next lives that were waited for
        self._restarts = restarts if lockstep else 0
        self._admissions = Admissions(run, scenarios[0].ids, lockstep, clock, self._journal)
        self._publishers = Publishers(bus, run, scenarios[0].ids)
        turn = Turn(0, scenarios[0], {}) if past is None else past.turn
        self._scenarios = iter(scenarios[turn.number + 1 :])
        self._begin(turn)
        if past is not None:
            self._remember(past)
        bus.subscribe(*[robot_key(run, i, "command") for i in scenarios[0].ids])
        bus.watch(every_robot(run, "alive"))
        for stream in ("control", "scenario"):
            bus.serve(world_key(run, stream))
        bus.announce(world_key(run, "alive"))
        if turn.world.verdict:
            self._end()

    def _remember(self, past: Resumed) -> None:
        """Go on where another process died. Whoever took part then is there until the grace is over."""
        self._expected.update(past.expected)
        for robot, session in past.sessions.items():
            life = past.turn.world.incarnations[robot]
            if past.turn.world.goes_on(robot, life):
                self._admissions.resume(robot, session, life)

    def _begin(self, turn: Turn) -> None:
        self._turn, self._phase = turn, Phase.RUNNING
        self._admissions.forget_reports()
        self._publishers.published = 0
        self._pacing.wait()

    @property
    def deadline(self) -> float:
        """When `wake` wants to be called next, s, monotonic."""
        return self._pacing.deadline

    # -- events

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            self._on_command(event.key, event.payload)
        elif isinstance(event, Presence):
            self._on_presence(event)
        else:
            event.reply(self._reply(event))
            self._advance()

    def _on_command(self, key: str, payload: bytes) -> None:
        turn = self._turn
        try:
            message = decode(key, payload)
        except MessageError as error:
            turn.rejected[error.reason] += 1
            return
        turn.received += 1
        if isinstance(message, Command) and turn.world.accept(message) and turn.world.complete:
            self._advance()

    def _on_presence(self, event: Presence) -> None:
        robot = self._robot_of(event.key)
        if robot is None:
            return
        if event.alive:
            self._admissions.arrive(robot)
            self._welcome()
        else:
            self._miss(robot)
        self._advance()

    def _welcome(self) -> None:
        """A token is there. If it is the last that was missing, what was said meanwhile is lost."""
        if self._turn.opened and self._lockstep and not self._admissions.missing():
            self._pacing.begin_again()
            self._publishers.measurements(self._turn.world.open_tick())

    def _miss(self, robot: int) -> None:
        """A token is gone; with it the process, unless its life goes on and there is a grace."""
        if self._grace and self._turn.world.goes_on(robot, self._admissions.slots[robot].granted):
            self._admissions.miss(robot)
        else:
            self._gone(robot)

    def _write_off(self) -> None:
        """Whoever has been missing for too long is gone."""
        for robot in self._admissions.missing(self._grace):
            self._gone(robot)

    def _bide(self, now: float) -> None:
        """No patience runs out while somebody is missing who may come back: nobody else can go on, either."""
        by_the_clock = self._turn.opened and not self._lockstep
        if self._admissions.missing() and not by_the_clock:
            self._pacing.since = now

    def _gone(self, robot: int) -> None:
        self._admissions.leave(robot)
        self._give_up({robot: "has gone: it ended, or is cut off"})
        self._expect(robot)

    def _robot_of(self, key: str) -> int | None:
        """Whose token this is; None, and counted, if it is no robot's of this run."""
        try:
            robot = parse(key).robot
        except KeyGrammarError:
            self._turn.rejected["key"] += 1
            return None
        if robot not in self._admissions.slots:
            self._turn.rejected["identity"] += 1
            return None
        return robot

    def _reply(self, request: Request) -> bytes:
        reason = "key"  # a request may be for a pattern that matches one of the world's keys
        try:
            if parse(request.key).stream == "control":
                return self._steer(request.payload)
            return joining.encode_reply(self._answer(request.payload))
        except KeyGrammarError as error:
            text = str(error)
        except MessageError as error:
            reason, text = error.reason, str(error)
        self._turn.rejected[reason] += 1
        return joining.encode_reply(joining.Refusal(text))

    def _steer(self, payload: bytes) -> bytes:
        steer = decode_steer(payload)
        if self._lockstep:
            self._pacing.steering.apply(steer)
        return msgspec.msgpack.encode(self._pacing.steering)

    def _answer(self, payload: bytes) -> joining.Reply:
        if not payload:
            return self._admissions.overview(self._turn)
        join = joining.decode_request(payload)
        refusal = self._admissions.refusal(join, self._turn)
        if refusal is not None:
            return refusal
        slot = self._admissions.slots[join.robot]
        if join.robot in self._admissions.missing() and join.session != slot.session:
            self._gone(join.robot)  # whose successor this is
        if self._phase is Phase.SHUTDOWN:
            slot.health = join.health or slot.health
            self._shut_down()
        if self._phase is Phase.SHUTDOWN:
            return joining.Wait(_ASK_AGAIN, "the run is being wound up")
        if self._phase is Phase.CLOSING:
            slot.notified = True
            return joining.Finished(self._turn.world.verdict)
        return self._admissions.enlist(join, self._turn)

    # -- the clock

    def wake(self, now: float) -> None:
        self._pacing.look_again(now)
        self._write_off()
        self._bide(now)
        if self._phase is not Phase.RUNNING:
            self._announce_end()
        elif self._lockstep or not self._turn.opened:
            self._keep_waiting(now)
        else:
            self._close()
        self._advance()

    def _advance(self) -> None:
        """Do all that can be done now."""
        while self._phase is Phase.RUNNING:
            if not self._turn.opened and not self._open():
                return
            if not (self._turn.world.complete and self._lockstep):
                return
            self._close()
        if self._phase is Phase.SHUTDOWN:
            self._shut_down()
        if self._phase is Phase.CLOSING and (not self._admissions.unnotified() or self._patience_is_over()):
            self.finished = True

    def _open(self) -> bool:
        """Open the next tick, unless somebody who has to be there is not, or it is held back."""
        turn = self._turn
        if not turn.world.founded and self._admissions.absent():
            return False
        measurements = turn.world.open_tick()
        if self._absent():
            if self._lockstep or turn.world.tick == 0:
                self._remind(measurements)
                return False
            measurements = self._open_without()
        if self._pacing.holds(turn.world.tick, turn.scenario.time.step):
            self._inform(due=False)
            return False
        turn.opened = True
        if turn.world.tick == 0:
            turn.began = self._pacing.now()
            if self._journal is not None:
                self._journal.note(Began(time.time()))
        self._pacing.begin(turn.world.tick, turn.scenario.time.step)
        self._publishers.measurements(measurements)  # first: the robots compute while this process judges
        self._inform(due=turn.world.tick == 0 or turn.is_marked() or not self._lockstep)
        return True

    def _inform(self, *, due: bool) -> None:
        """Tell those who watch, if it is `due` for its own sake or again."""
        if due or self._publishers.is_due:
            self._publishers.watched(self._turn.clock(), self._turn.world.news())

    def _absent(self) -> frozenset[int]:
        """Robots that have to be there and are not: not joined, or joined without a token."""
        world = self._turn.world
        if not world.founded:
            return world.awaiting_join | self._admissions.absent()
        return world.awaiting_join | (self._admissions.absent() & frozenset(world.active))

    def _remind(self, measurements: dict[int, Measurement]) -> None:
        """A fenced life that the scenario wants back must learn that it has to join again."""
        awaited = self._turn.world.awaiting_join
        self._publishers.measurements({robot: m for robot, m in measurements.items() if robot in awaited})

    def _open_without(self) -> dict[int, Measurement]:
        """Real time waits for nobody; who comes later joins then."""
        world = self._turn.world
        for robot in world.awaiting_join:
            world.give_up_waiting(robot)
        return world.open_tick()

    def _close(self) -> None:
        turn = self._turn
        turn.world.close_tick()
        turn.opened = False
        if turn.world.verdict:
            self._end()

    # -- waiting for somebody

    def _keep_waiting(self, now: float) -> None:
        """Say that it goes on, and give up in time."""
        turn = self._turn
        self._inform(due=True)
        if turn.opened:
            if now > self._pacing.since + self._patience and self._pacing.has_repeated:
                self._lose_patience()
            elif self._pacing.repeats():
                self._publishers.measurements(turn.world.open_tick())
        elif not self._absent():
            self._pacing.since = now  # held back by a viewer, not by a robot
        elif now > self._pacing.since + self._gathering:
            self._give_up_gathering()

    def _lose_patience(self) -> None:
        """Give up who is sick, and have patience with the others."""
        blamed = self._turn.world.blamed()
        for robot in blamed:
            self._admissions.blame(robot)
        self._pacing.begin_again()
        self._give_up(blamed)

    def _give_up_gathering(self) -> None:
        world, absent = self._turn.world, sorted(self._absent())
        if world.tick == 0:
            names = ", ".join(map(str, absent))
            world.finish("aborted", f"no sign of robot {names} within {self._gathering:g} s")
            self._end()
        reason = f"gave no sign within {self._gathering:g} s"
        for robot in absent:
            if world.give_up_waiting(robot, reason) or world.lost(robot, reason):
                self._tell_person(robot, reason)

    def _give_up(self, robots: Mapping[int, str]) -> None:
        """These do not take part any more, with the reasons; whoever waits for their states must know."""
        world = self._turn.world
        running = self._phase is Phase.RUNNING
        for robot, reason in robots.items():
            if world.lost(robot, reason if running else "") and running:
                self._tell_person(robot, reason)
        if self._turn.opened and self._lockstep:
            waiting = world.waiting
            self._publishers.measurements({r: m for r, m in world.open_tick().items() if r in waiting})

    def _tell_person(self, robot: int, reason: str) -> None:
        self._say(f"tick {self._turn.world.tick}: gives up robot {robot}, which {reason}")

    def _expect(self, robot: int) -> None:
        """Wait for the next life of a robot that is started again."""
        if self._phase is Phase.RUNNING and self._expected[robot] < self._restarts:
            self._expected[robot] += 1
            self._turn.world.expect(robot)

    # -- the end

    def interrupt(self, verdict: str, reason: str) -> None:
        """End everything from outside, for example on Ctrl-C; the report stays readable."""
        self._scenarios = iter(())
        if self._phase is Phase.RUNNING:
            self._turn.world.finish(verdict, reason)
            self._end()
        self._conclude()
        self.finished = True

    def _end(self) -> None:
        self._phase = Phase.SHUTDOWN
        self._pacing.wait()
        self._announce_end()

    def _announce_end(self) -> None:
        """Whoever has not heard that the run is over hears it (again)."""
        self._inform(due=True)
        remaining = (
            self._admissions.owing_health()
            if self._phase is Phase.SHUTDOWN
            else self._admissions.unnotified()
        )
        self._publishers.measurements(self._turn.final_measurements(remaining))

    def _shut_down(self) -> None:
        """Once the robots have reported, or had the time to, publish the result."""
        if not self._admissions.owing_health() or self._patience_is_over():
            self._conclude()

    def _patience_is_over(self) -> bool:
        return self._pacing.waited() > SHUTDOWN

    def _conclude(self) -> None:
        """Publish the result and go on to the next run, if there is one."""
        if self._phase is not Phase.SHUTDOWN:
            return
        turn, slots = self._turn, self._admissions.slots.values()
        report = turn.report((slot.health for slot in slots), self._publishers.published, self._pacing.since)
        self.reports.append(report)
        self._tell(report)
        self._publishers.result(report)
        following = next(self._scenarios, None)
        if following is None:
            self._phase = Phase.CLOSING
            self._pacing.wait()
        else:
            self._begin(self._next(following))

    def _next(self, scenario: Scenario) -> Turn:
        """The turn after this one."""
        number, world = self._turn.number + 1, self._turn.world
        turn = Turn(number, scenario, world.incarnations, world.version)
        if self._journal is not None:
            self._journal.begin(number, world.incarnations, world.version, self._expected)
            turn.world.note = self._journal.note
        return turn
