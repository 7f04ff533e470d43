"""Sources of a view: a watcher of a run on any bus, and a player of a recording."""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from queue import SimpleQueue

import msgspec

from deploy.telemetry.live import FleetView
from deploy.telemetry.monitor.snapshot import Source
from protocol.bus.bus import Bus, Event, Presence, Sample, drive
from protocol.codec import decode
from protocol.errors import BusError, KeyGrammarError, MessageError
from protocol.joining import overview
from protocol.keys import every_robot, parse, robot_tokens, world_key, world_tokens
from protocol.messages import Message
from protocol.operations import Outcome, Reply, Steer, Steering, decode_reply
from protocol.process.signals import Stopped
from protocol.scenario.model import Operation, Scenario

PERIOD = 0.05  # s between handling requests of viewers
RETRY = 0.5  # s between queries for the scenario
_ANSWER = 2.0  # s for a world to answer
_UNANSWERED = "no answer, but it may be obeyed: the world is gone, or this page lacks the operator's key"
_NO_RUN = "the run has not started"


class Watcher(Source):
    """A `Node` for the thread that owns `bus`, its own connection, and a `Source` for all others, which may
    steer the run.

    Attributes:
        follow: called with the view, under its lock, after each message that it has taken; and with None
            instead of the message when a scenario begins.
    """

    def __init__(self, bus: Bus, run: str) -> None:
        super().__init__(run)
        self.follow: Callable[[FleetView, Message | None], None] = lambda *_: None
        self.finished = False
        self.deadline = self._ask_at = time.monotonic()
        self._bus, self._run = bus, run
        self._tokens: defaultdict[int | None, set[str]] = defaultdict(set)  # by robot; None for worlds
        self._wishes: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._there, self._known = False, False  # whether a world is present, its scenario known
        bus.subscribe(world_key(run, "clock"), world_key(run, "truth"))
        bus.subscribe(every_robot(run, "health"), every_robot(run, "goalstatus"))
        bus.watch(robot_tokens(run))
        bus.watch(world_tokens(run))

    def steer(self, steer: Steer) -> None:
        """Request a pause, steps or a speed of the thread that owns the bus."""
        self._wishes.put(partial(self._ask_for, steer))

    def operate(self, operation: Operation) -> Future[Outcome]:
        """Request an operation of the thread that owns the bus."""
        answer: Future[Outcome] = Future()
        if self._known:
            self._wishes.put(lambda: answer.set_result(self._request(operation)))
        else:
            answer.set_result(Outcome(False, text=_NO_RUN))
        return answer

    # -- in the thread that owns the bus

    def handle(self, event: Event) -> None:
        """Take a message or a token's change."""
        if isinstance(event, Presence):
            self._on_presence(event)
        elif isinstance(event, Sample):
            self._on_sample(event)
        if (now := time.monotonic()) >= self.deadline:
            self.on_timer(now)

    def on_timer(self, now: float) -> None:
        """Query the scenario if it is unknown, and forward requests of viewers."""
        self.deadline = now + PERIOD
        unknown = self._view.strangers if self._known else self._there
        if unknown and now >= self._ask_at:
            self._learn(anew=not self._known)
            self._ask_at = time.monotonic() + RETRY
        while self._known and not self._wishes.empty():
            self._wishes.get()()

    def _on_presence(self, event: Presence) -> None:
        try:
            robot = parse(event.key).robot
        except KeyGrammarError:  # not a token of this software
            return
        tokens = self._tokens[robot]
        (tokens.add if event.alive else tokens.discard)(event.key)
        alive = bool(tokens)
        self.change(lambda view, _: view.on_token(robot, alive))
        if robot is None:
            if alive and not self._there:
                self._known, self._ask_at = False, 0.0  # it may be another world of this name
            self._there = alive

    def _on_sample(self, sample: Sample) -> None:
        try:
            message = decode(sample.key, sample.payload)
        except MessageError:
            return
        if self._known and self.change(lambda view, _: view.is_news(message)):
            self._learn()
        self.change(lambda view, now: self._take(view, message, now))

    def _take(self, view: FleetView, message: Message, now: float) -> None:
        view.on_message(message, now)
        self.follow(view, message)

    def _learn(self, *, anew: bool = True) -> None:
        """Query the scenario; without an answer a later `on_timer` repeats it. Unless `anew`, only for the
        robots that are strangers.
        """
        reply = overview(self._bus, self._run, _ANSWER)
        self._known = reply is not None
        if reply is None:
            return
        if not anew:
            self.change(lambda view, _: view.update(reply.scenario, reply.goals))
            return
        self.change(lambda view, _: view.begin(reply.scenario, reply.lockstep, reply.goals))
        self.change(lambda view, _: self.follow(view, None))
        self._ask_for(Steer())  # changes nothing; the answer has the settings in force

    def _request(self, operation: Operation) -> Outcome:
        """Outcome of an operation; a refusal if one of several worlds refuses."""
        try:
            key, request = world_key(self._run, "operation"), msgspec.msgpack.encode(operation)
            answers = self._bus.ask(key, request, _ANSWER, once=not operation.halt)
            replies = [decode_reply(each, Reply) for each in answers]
        except (BusError, MessageError):
            return Outcome(False, text=_UNANSWERED)
        reply = min(replies, key=lambda each: each.accepted)
        status = None if operation.goal is None else reply.goal(operation.goal.robot)
        if status is not None:
            self.change(lambda view, now: self._take(view, status, now))
        return reply

    def _ask_for(self, steer: Steer) -> None:
        try:
            key, request = world_key(self._run, "steering"), msgspec.msgpack.encode(steer)
            steering = decode_reply(self._bus.ask(key, request, _ANSWER, once=steer != Steer())[0], Steering)
        except (BusError, MessageError):
            return  # the world is gone, or of another version: the controls stay as shown
        self.change(lambda view, _: setattr(view, "steering", steering))


class Attachment(Watcher):
    """A watcher with a thread of its own, until `close` or a signal, also of a run that has not started.

    It cannot slow down the fleet: messages that this process cannot keep up with are dropped.
    """

    def __init__(self, bus: Bus, run: str) -> None:
        super().__init__(bus, run)
        self._thread = threading.Thread(target=self._watch, name=f"monitor of {run}", daemon=True)
        self._thread.start()

    def _watch(self) -> None:
        with suppress(Stopped):  # while it waited for an answer
            drive(self, self._bus)

    def close(self) -> None:
        """Stop and disconnect; may be called twice."""
        self.finished = True
        self._thread.join()


_NAP = 0.01  # s, longest wait between checks of the steering


class Player(Source):
    """Plays recorded messages in a thread until the end or `close`; pause, steps and speed apply to the
    playback.

    Args:
        entries: simulated time (s, ascending) and message.
        speed: recorded seconds per second; 0: as fast as the machine allows.
        paused: whether it begins once a viewer resumes it.
    """

    def __init__(
        self,
        scenario: Scenario,
        run: str,
        entries: Iterable[tuple[float, Message]],
        *,
        speed: float = 1.0,
        paused: bool = False,
    ) -> None:
        super().__init__(run)
        self._steering = self._view.steering = Steering(paused=paused, speed=speed)
        self._closed = False
        self.change(lambda view, _: view.begin(scenario, True))
        self._thread = threading.Thread(
            target=self._play, args=(entries,), name=f"replay of {run}", daemon=True
        )
        self._thread.start()

    def steer(self, steer: Steer) -> None:
        with self._lock:
            self._steering.apply(steer)

    def operate(self, operation: Operation) -> Future[Outcome]:  # noqa: ARG002
        """Refuse the operation."""
        answer: Future[Outcome] = Future()
        answer.set_result(Outcome(False, text="this is a recording: it accepts no orders"))
        return answer

    def close(self) -> None:
        """Stop; may be called twice."""
        self._closed = True
        self._thread.join()

    def join(self, timeout: float | None = None) -> bool:
        """Wait for the end of the recording; False if `timeout` passes first."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _play(self, entries: Iterable[tuple[float, Message]]) -> None:
        played = 0.0
        for moment, message in entries:
            if moment > played:
                self._wait(moment - played)
                played = moment
            if self._closed:
                return
            with self._lock:
                self._view.on_message(message, self._clock())

    def _wait(self, seconds: float) -> None:
        while seconds > 0.0 and not self._closed:
            began = time.monotonic()
            with self._lock:
                paused, speed = self._steering.paused, self._steering.speed
                if (paused and self._steering.allow()) or (not paused and speed == 0.0):
                    return
            time.sleep(_NAP if paused else min(_NAP, seconds / speed))
            if not paused:
                seconds -= (time.monotonic() - began) * speed
