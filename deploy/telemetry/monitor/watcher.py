"""Sources of a view: a participant that watches one run on any bus, and a recording played in its place."""

from __future__ import annotations

import threading
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from functools import partial
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING

import msgspec

from deploy.telemetry.monitor.live import FleetView
from deploy.telemetry.monitor.snapshot import Steerable
from protocol import joining
from protocol.bus.bus import Bus, Event, Presence, Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode
from protocol.errors import BusError, KeyGrammarError, MessageError
from protocol.joining import Overview
from protocol.keys import checked_run, every_robot, parse, robot_tokens, world_key, world_tokens
from protocol.messages import AnyMessage, Message
from protocol.operations import Outcome, Reply, Steer, Steering, decode_reply
from protocol.scenario.model import Operation, Scenario

if TYPE_CHECKING:
    from deploy.telemetry.monitor.foxglove import FoxgloveServer


PERIOD = 0.05  # s between looks at what viewers ask for
RETRY = 0.5  # s between attempts to learn the scenario
_ASK_TIMEOUT = 2.0
_UNANSWERED = "no answer: the world has gone, or the keys of this page are not an operator's"
_NO_RUN = "there is no run yet"


class Watcher(Steerable):
    """A `protocol.bus.bus.Node` to the thread that owns `bus`, a `Steerable` to all others.

    Attributes:
        rejected: messages and tokens that were refused, by reason.
    """

    def __init__(self, bus: Bus, run: str, *, listener: FoxgloveServer | None = None) -> None:
        """Args:
        bus: a connection of its own.
        run: name of the run.
        listener: gets what the view gets, on the thread that owns the bus.
        """
        super().__init__(run)
        self.finished = False
        self.rejected: Counter[str] = Counter()
        self.deadline = time.monotonic()
        self._bus, self._run, self._listener = bus, run, listener
        self._tokens: defaultdict[int | None, set[str]] = defaultdict(set)  # by robot; None for worlds
        self._wishes: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._there, self._known = False, False  # the world; the scenario it runs
        self._ask_at = self.deadline
        for stream in ("clock", "truth"):
            bus.subscribe(world_key(run, stream))
        for stream in ("health", "goalstatus"):
            bus.subscribe(every_robot(run, stream))
        bus.watch(robot_tokens(run))
        bus.watch(world_tokens(run))

    def steer(self, steer: Steer) -> None:
        """Wait for the owning thread to pass it on; see `Steerable.steer`."""
        self._wishes.put(partial(self._ask_for, steer))

    def operate(self, operation: Operation) -> Future[Outcome]:
        """Wait for the owning thread to pass it on; see `Steerable.operate`."""
        answer: Future[Outcome] = Future()
        if self._known:
            self._wishes.put(lambda: answer.set_result(self._request(operation)))
        else:
            answer.set_result(Outcome(False, text=_NO_RUN))
        return answer

    # -- on the thread that owns the bus

    def handle(self, event: Event) -> None:
        """Take over what was published, or which processes came and went."""
        if isinstance(event, Presence):
            self._on_presence(event)
        elif isinstance(event, Sample):
            self._on_sample(event)
        if (now := time.monotonic()) >= self.deadline:
            self.wake(now)

    def wake(self, now: float) -> None:
        """Learn the scenario if it is unknown, and pass on what viewers asked for."""
        self.deadline = now + PERIOD
        if self._there and not self._known and now >= self._ask_at:
            self._learn()
            self._ask_at = time.monotonic() + RETRY
        if self._known and self._view.strangers and now >= self._ask_at:
            self._meet()
            self._ask_at = time.monotonic() + RETRY
        if self._known:
            self._pass_on()

    def _on_presence(self, event: Presence) -> None:
        try:
            robot = parse(event.key).robot
        except KeyGrammarError:
            self.rejected["key"] += 1  # a stranger's token under our name says nothing about any robot
            return
        tokens = self._tokens[robot]
        (tokens.add if event.alive else tokens.discard)(event.key)
        alive = bool(tokens)
        self.change(lambda view, _: view.present(robot, alive))
        if robot is None:
            if alive and not self._there:
                self._known, self._ask_at = False, 0.0  # perhaps another world under this name
            self._there = alive

    def _on_sample(self, sample: Sample) -> None:
        try:
            message = decode(sample.key, sample.payload)
        except MessageError as error:
            self.rejected[error.reason] += 1
            return
        if self._known and self._is_news(message):
            self._learn()
        self.change(lambda view, now: view.on_message(message, now))
        if self._known and self._listener is not None:
            self._listener.hear(message)

    def _is_news(self, message: AnyMessage) -> bool:
        news = False

        def look(view: FleetView, _: float) -> None:
            nonlocal news
            news = view.is_news(message)

        self.change(look)
        return news

    def _learn(self) -> None:
        """Ask the world for the scenario; without an answer, a later `wake` asks again."""
        reply = self._present()
        self._known = reply is not None
        if reply is not None:
            self.change(lambda view, _: view.begin(reply.scenario, reply.lockstep, reply.goals))
            if self._listener is not None:
                self._listener.begin(reply.scenario)
                for status in reply.goals:
                    self._listener.hear(status)
            self._ask_for(Steer())  # which changes nothing: what is in force is the answer

    def _meet(self) -> None:
        """Ask the world for robots that came and that no message describes."""
        reply = self._present()
        if reply is None:
            self._known = False
            return
        self.change(lambda view, _: view.meet(reply.scenario, reply.goals))
        if self._listener is not None:
            self._listener.meet(reply.scenario)

    def _present(self) -> Overview | None:
        """What the world says of its run; None without an answer."""
        try:
            reply = joining.decode_reply(
                self._bus.ask(world_key(self._run, "scenario"), b"", _ASK_TIMEOUT)[0]
            )
        except (BusError, MessageError):
            return None
        return reply if isinstance(reply, Overview) else None

    def _pass_on(self) -> None:
        while True:
            try:
                wish = self._wishes.get_nowait()
            except Empty:
                return
            wish()

    def _request(self, operation: Operation) -> Outcome:
        """The outcome of an operation; of several worlds, one that refuses it."""
        try:
            key, request = world_key(self._run, "operation"), msgspec.msgpack.encode(operation)
            replies = [decode_reply(each, Reply) for each in self._bus.ask(key, request, _ASK_TIMEOUT)]
        except (BusError, MessageError):
            return Outcome(False, text=_UNANSWERED)
        reply = min(replies, key=lambda each: each.accepted)
        status = None if operation.goal is None else reply.goal(operation.goal.robot)
        if status is not None:
            self.change(lambda view, now: view.on_message(status, now))
        return reply

    def _ask_for(self, steer: Steer) -> None:
        try:
            key, request = world_key(self._run, "steering"), msgspec.msgpack.encode(steer)
            steering = decode_reply(self._bus.ask(key, request, _ASK_TIMEOUT)[0], Steering)
        except (BusError, MessageError):
            return  # the world has gone, or is of another version: its controls stay as they are shown
        self.change(lambda view, _: setattr(view, "steering", steering))


_LONGEST_WAIT = 0.05  # s; how soon `close` is noticed


class Attachment(Watcher):
    """A watcher that drives itself until `close`."""

    def __init__(self, bus: Bus, run: str, *, listener: FoxgloveServer | None = None) -> None:
        super().__init__(bus, run, listener=listener)
        self._thread = threading.Thread(target=self._loop, name=f"monitor of {run}", daemon=True)
        self._thread.start()

    def _loop(self) -> None:
        try:
            while not self.finished:
                now = time.monotonic()
                if now >= self.deadline:
                    self.wake(now)
                event = self._bus.receive(min(_LONGEST_WAIT, max(0.0, self.deadline - now)))
                if event is not None:
                    self.handle(event)
        finally:
            self._bus.close()

    def close(self) -> None:
        """Stop watching and disconnect; may be called twice."""
        self.finished = True
        self._thread.join()


def attach(connection: Connection, run: str, *, listener: FoxgloveServer | None = None) -> Attachment:
    """Watch `run` over a session of its own. The run need not be there yet.

    The fleet does not notice: all that is subscribed to is dropped rather than waited for when this
    process cannot keep up.

    Raises:
        BusError: nothing listens where `connection` leads.
        KeyGrammarError: the run name cannot be one.
    """
    checked_run(run)
    return Attachment(ZenohBus(connection), run, listener=listener)


_NAP = 0.01  # s, longest wait before steering is looked at again


class Player(Steerable):
    """Plays on a thread of its own until the end or `close`; pause, step and speed act on the playback."""

    def __init__(
        self, scenario: Scenario, run: str, entries: Iterable[tuple[float, Message]], *, speed: float = 1.0
    ) -> None:
        """Args:
        scenario: what was run.
        run: its name.
        entries: simulated time (s, never falling) and message.
        speed: recorded seconds per second; 0 is as fast as the machine allows.
        """
        super().__init__(run)
        self._steering = Steering(speed=speed)
        self._changed = threading.Lock()
        self._closed = False
        self.change(lambda view, _: view.begin(scenario, True))
        self._show()
        self._thread = threading.Thread(
            target=self._play, args=(entries,), name=f"replay of {run}", daemon=True
        )
        self._thread.start()

    def steer(self, steer: Steer) -> None:
        """See `Steerable.steer`."""
        with self._changed:
            self._steering.apply(steer)
        self._show()

    def operate(self, operation: Operation) -> Future[Outcome]:  # noqa: ARG002
        """Refuse: what was recorded has happened."""
        answer: Future[Outcome] = Future()
        answer.set_result(Outcome(False, text="this is a recording: its robots go where they went"))
        return answer

    def close(self) -> None:
        """Stop playing; may be called twice."""
        self._closed = True
        self._thread.join()

    def join(self, timeout: float | None = None) -> bool:
        """Wait for the end of the recording; whether it was reached."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _show(self) -> None:
        steering = Steering(self._steering.paused, 0, self._steering.speed)
        self.change(lambda view, _: setattr(view, "steering", steering))

    def _play(self, entries: Iterable[tuple[float, Message]]) -> None:
        played = 0.0
        for moment, message in entries:
            if moment > played:
                self._wait(moment - played)
                played = moment
            if self._closed:
                return
            self.change(partial(_hear, message))

    def _wait(self, seconds: float) -> None:
        """Let recorded time pass: at the speed that is set, in steps, or not at all while paused."""
        while seconds > 0.0 and not self._closed:
            began = time.monotonic()
            with self._changed:
                paused, speed = self._steering.paused, self._steering.speed
                if (paused and self._steering.allow()) or (not paused and speed == 0.0):
                    return
            time.sleep(_NAP if paused else min(_NAP, seconds / speed))
            if not paused:
                seconds -= (time.monotonic() - began) * speed


def _hear(message: Message, view: FleetView, now: float) -> None:
    view.on_message(message, now)
