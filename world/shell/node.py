"""The world's node: admits robots, drives the clock, publishes the result.

Lock-step: a tick begins when every active robot is present, and ends when each has commanded. Real time:
ticks end by the wall clock, with or without Commands; the first waits for a while. All waits are bounded
(`world/shell/failure_detector.py`). With a checkpoint the node continues the run of a dead predecessor, as
another coordinator: all lives are over, and all robots join again before the tick that was open is repeated.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from protocol import joining
from protocol.bus.bus import Bus, Event, Presence, Query, Sample
from protocol.codec import SHOWN, decode
from protocol.errors import KeyGrammarError, MessageError
from protocol.keys import (
    Address,
    every_robot,
    parse,
    robot_key,
    robot_tokens,
    session_of,
    world_key,
    world_token,
    world_tokens,
)
from protocol.messages import Command, Tick
from protocol.operations import encode_reply
from protocol.scenario.model import Scenario
from world.shell.admission import Admissions
from world.shell.checkpoint import Checkpoint, SavedRun
from world.shell.failure_detector import GATHERING, GRACE, PATIENCE, FailureDetector, returning
from world.shell.operations import Operations
from world.shell.pacing import Pacing
from world.shell.publishers import Publishers
from world.shell.run import JudgedRun, Phase, Shutdown, drawn_epoch
from world.world import WorldCore


class WorldNode:
    """The world of one run, on one bus.

    Args:
        bus: a connection of its own.
        scenario: k already a number.
        lockstep: whether ticks wait for the robots; they never wait for external ones.
        gathering: time for robots to join, s.
        patience: time for a Command in lock-step, s.
        speed: simulated seconds per second in lock-step, 0 for no limit.
        restarts: number of restarts of a robot whose process ends; lock-step waits for them.
        clock: time, s; for tests.
        warn, info, on_report: take warnings for the operator, lines for the log, and the report.
        checkpoint: state to continue from; changes are written to it before they are published. A missing
            robot may return within GRACE, unless another process takes its slot.
    """

    def __init__(
        self,
        bus: Bus,
        run: str,
        scenario: Scenario,
        lockstep: bool = True,
        *,
        gathering: float = GATHERING,
        patience: float = PATIENCE,
        speed: float = 0.0,
        restarts: int = 0,
        clock: Callable[[], float] = time.monotonic,
        warn: Callable[[str], None] = lambda _: None,
        info: Callable[[str], None] = lambda _: None,
        checkpoint: Checkpoint | None = None,
        on_report: Callable[[dict[str, Any]], None] = lambda _: None,
    ) -> None:
        self.report: dict[str, Any] | None = None  # of the run once it has ended
        self.finished = False
        self.refused = False  # whether it has left the run to another world
        lockstep = lockstep and not scenario.is_external
        self._pacing = Pacing(lockstep, speed, clock)
        self._lockstep = lockstep
        self._standing: set[int] = set()  # robots whose disks are obstacles, as reported
        self._checkpoint = checkpoint
        self._on_report, self._info, self._warn = on_report, info, warn
        waits = returning(gathering, restarts, lockstep=lockstep)
        before = SavedRun() if checkpoint is None else checkpoint.progress
        self._run = JudgedRun(scenario, before.past, returning=waits)
        lives, epoch = self._run.world.lives, drawn_epoch(continues=bool(before.epochs))
        self._epoch, self._epochs, self._session = epoch, (*before.epochs, epoch), session_of(epoch)
        self._admissions = Admissions(
            run, self._run.world, lockstep, clock, self._epochs, checkpoint, before.processes
        )
        ids = {*scenario.ids, *lives.of, *lives.roster.members}
        ids.update(spec.id for spec in scenario.newcomers)
        self._publishers = Publishers(bus, run, ids, epoch)
        self._operations = Operations(
            bus, run, self._run, self._publishers, self._pacing, warn=warn, info=info
        )
        self._failures = FailureDetector(
            self._run,
            self._admissions,
            self._pacing,
            self._send_again,
            gathering=gathering,
            patience=patience,
            grace=0.0 if checkpoint is None else GRACE,
            restarts=restarts,
            warn=warn,
        )
        self._shutdown = Shutdown(self._run, self._admissions, self._pacing)
        self._pacing.wait()
        if before.epochs:  # another process died there
            self._run.began = time.monotonic() - max(0.0, time.time() - before.began)
        bus.subscribe(*[robot_key(run, i, "command") for i in sorted(ids)])
        bus.watch(robot_tokens(run))
        for stream in ("steering", "scenario", "operation"):
            bus.serve(world_key(run, stream))
        bus.serve(every_robot(run, "join"))
        bus.announce(world_token(run, self._session))
        bus.watch(world_tokens(run))
        if self._run.world.verdict:
            self._end()
        elif before.epochs:
            self._advance()  # events of the scenario precede admissions in a tick

    def _save(self) -> None:
        """Write the state; what became of orders is published afterwards, so that no successor unsays it."""
        checkpoint, run = self._checkpoint, self._run
        if checkpoint is not None and checkpoint.kept:
            began = time.time() - (time.monotonic() - run.began)
            checkpoint.write(SavedRun(self._epochs, began, self._admissions.processes, run.world.past))
        self._publishers.goals(run.world.missions.news())

    @property
    def _stop(self) -> tuple[bool, int]:
        return self.world.halted, self.world.stops

    @property
    def world(self) -> WorldCore:
        return self._run.world

    @property
    def deadline(self) -> float:
        """Time of the next `on_timer`, s, monotonic."""
        return self._pacing.deadline

    # -- events

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            self._on_command(event.key, event.payload)
        elif isinstance(event, Presence):
            self._on_presence(event)
        elif isinstance(event, Query):
            before, reply = self._stop, self._reply(event)
            self._save()
            if self._stop != before:
                self._inform(due=True)
            event.reply(reply)
            self._advance()

    def _on_command(self, key: str, payload: bytes) -> None:
        run = self._run
        try:
            message = decode(key, payload)
        except MessageError as error:
            self._reject(error.reason, f"{key}: {error}")
            return
        if not isinstance(message, Command) or message.epoch != self._epoch:
            run.rejected["epoch"] += 1
            return
        run.received += 1
        if run.world.accept(message) and not run.world.exchange.waiting:
            self._advance()

    def _on_presence(self, event: Presence) -> None:
        try:
            _, robot, _, session = parse(event.key)
        except KeyGrammarError:
            self._run.rejected["key"] += 1
            return
        if robot is None:
            if session != self._session:
                self._on_world(session, event.alive)
        elif robot not in self._publishers:
            self._run.rejected["identity"] += 1
            return
        elif event.alive:
            self._failures.arrive(robot, session)
        else:
            self._failures.miss(robot, session)
        self._advance()

    def _on_world(self, session: str, alive: bool) -> None:
        """Another world appeared or disappeared. Of two with runs that have not begun one leaves."""
        self._operations.on_world(session, alive)
        if alive and not self._run.world.lives.founded and session < self._session:
            self._give_way()

    def _give_way(self) -> None:
        """Leave the run to another world, without a result."""
        self.refused = self.finished = True

    def _reply(self, request: Query) -> bytes:
        reason = "key"  # a request may be for a pattern that matches one of the world's keys
        try:
            address = parse(request.key)
            reply = self._operations.reply(address, request.payload)
            return reply or joining.encode_reply(self._answer(address, request.payload))
        except KeyGrammarError as error:
            text = str(error)
        except MessageError as error:
            reason, text = error.reason, str(error)
        self._reject(reason, f"{request.key}: {text}")
        return encode_reply(joining.Refusal(text), request.payload)

    def _reject(self, reason: str, text: str) -> None:
        """Count what is dropped, and report the first for each reason."""
        self._run.rejected[reason] += 1
        if self._run.rejected[reason] == 1:
            self._warn(f"tick {self._run.world.tick}: dropped a message, {text[:SHOWN]!r}")

    def _answer(self, asked: Address, payload: bytes) -> joining.JoinReply:
        if asked.stream == "scenario":
            return self._admissions.overview()
        if asked.robot is None or asked.stream != "join":
            raise KeyGrammarError(f"nothing can be asked for under {asked.stream!r}")
        join = joining.decode_request(asked.robot, payload)
        refusal = self._admissions.refusal(join)
        if isinstance(refusal, joining.Finished) and self._admissions.is_newest(join):
            self._run.world.lives.dismiss(join.robot)
        if refusal is not None:
            return self._shutdown.instead(refusal, join.robot)
        self._failures.supersede(join)
        self._shutdown.take_report(join)
        self._conclude_in_time()
        admissions = self._admissions
        return self._shutdown.reply(join) or admissions.refusal(join) or admissions.enlist(join)

    # -- the clock

    def on_timer(self, now: float) -> None:
        self._pacing.look_again(now)
        self._failures.look(now)
        if self._run.phase is not Phase.RUNNING:
            self._announce_end()
        elif self._lockstep or not self._run.opened:
            self._inform(due=True)
            self._failures.wait(now)
            if self.world.verdict and self.world.contested and not self.world.lives.founded:
                self._give_way()  # the robots that it misses take part in the other's run
            elif self.world.verdict:
                self._end()
        elif not (self.world.exchange.waiting and self._pacing.prolongs(self.world.tick, now)):
            self._close()
        self._advance()

    def _advance(self) -> None:
        while self._run.phase is Phase.RUNNING:
            if not self._run.opened and (not self._open() or self._is_idle):
                return
            if self._run.world.exchange.waiting or not self._lockstep:
                return
            self._close()
        self._conclude_in_time()
        if self._shutdown.is_over():
            self.finished = True

    @property
    def _is_idle(self) -> bool:
        """Whether there is neither a robot to wait for nor an end of the run; robots may join later."""
        return self._run.scenario.time.endless and not self._run.world.exchange.active

    def _open(self) -> bool:
        """Open the next tick, unless a required robot is missing or the clock is paused; True if done."""
        run = self._run
        for robot in run.world.lives.newcomers:
            self._admissions.expect(robot)
        ticks = self._failures.gather()
        self._save()
        if ticks is None:
            return False
        if self._pacing.holds(run.world.tick, run.scenario.time.step):
            self._inform(due=False)
            return False
        run.opened = True
        if run.world.tick == 0:
            run.began = self._pacing.now()
            self._info(f"scenario {run.scenario.name!r} begins with robots {list(run.scenario.ids)}")
        self._pacing.begin(run.world.tick, run.scenario.time.step)
        summary = run.world.exchange.summary
        if summary is not None and summary.tick == run.world.tick:
            self._publishers.summary(summary)
        self._publishers.ticks(ticks)  # first: the robots compute while this process judges
        if not self._lockstep:
            self._report_standing()
        self._inform(due=run.world.tick == 0 or run.is_marked() or not self._lockstep)
        return True

    def _report_standing(self) -> None:
        """Report the robots that have become obstacles."""
        before, tick = self._standing, self.world.tick
        self._standing = {each.robot for each in self.world.lives.roster.standing}
        for robot in sorted(self._standing - before):
            self._warn(f"tick {tick}: robot {robot} takes no part; its disk is an obstacle")

    def _send_again(self, ticks: Mapping[int, Tick]) -> None:
        """Repeat the Ticks and the summary, which may have been lost."""
        summary = self._run.world.exchange.summary
        if summary is not None:
            self._publishers.summary(summary)
        self._publishers.ticks(ticks)

    def _inform(self, *, due: bool) -> None:
        """Publish Clock and Truth to monitors if `due`, or if the last ones are old."""
        if due or self._publishers.is_due:
            self._publishers.watched(self._run.clock(), self._run.news())

    def _close(self) -> None:
        run = self._run
        run.world.close_tick()
        run.opened = False
        if run.world.verdict:
            self._end()

    # -- the end

    def interrupt(self, verdict: str, reason: str) -> None:
        """End the run from outside, for example on Ctrl-C; the report stays available."""
        if self._run.phase is Phase.RUNNING:
            self._run.world.finish(verdict, reason)
            self._end()
        self._conclude()
        self.finished = True

    def _end(self) -> None:
        self._save()
        self._shutdown.begin()
        self._announce_end()

    def _announce_end(self) -> None:
        """Publish or repeat the end of the run: a Clock to monitors, a final Tick to uninformed robots."""
        self._inform(due=True)
        self._publishers.ticks(self._shutdown.final_ticks())

    def _conclude_in_time(self) -> None:
        if self._shutdown.is_reported():
            self._conclude()

    def _conclude(self) -> None:
        if self._run.phase is not Phase.SHUTDOWN:
            return
        report = self._shutdown.report(self._publishers.published)
        self.report = report
        self._info(f"scenario {report['scenario']!r} ends: {report['verdict']} {report['reason']}".rstrip())
        self._on_report(report)
        self._publishers.result(report)
        self._shutdown.close()
