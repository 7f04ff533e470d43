"""A robot as a participant: joins a run, and binds a `Robot` to a bus.

Lock-step: the State goes out when the Tick arrives, the Command when the States of all that
take part are there. When the world tells the same tick again, both go out again, or instead of the
Command whose States are missing. Real time: both go out at once, and nobody is waited for. When a run
ends, or the world has fenced this life, it joins again: as a new life, or to learn that it is over.
A robot that is not simulated has a base, too: it shows its token once it knows where it is.
"""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from math import inf
from typing import Final

from msgspec.structs import replace

from agents.bases.base import Base
from agents.bases.choice import base_of
from agents.bases.start import misplaced
from agents.peers.reader import PeerReader
from agents.peers.state import PeerState
from agents.robot import Robot
from protocol.bus.bus import Bus
from protocol.bus.events import Event, Presence, Sample
from protocol.errors import BusError, JoinError, MessageError
from protocol.keys import robot_key, world_key
from protocol.messages import AnyMessage, Health, Roster, Sense, State, Summary, Tick
from protocol.requests import joining
from protocol.streams import STREAMS
from protocol.wire.codec import decode, encode

PATIENCE: Final = 10.0  # s without a word from the world before it is asked for a sign of life, or given up
REPORT_PERIOD: Final = 0.5  # s between health messages
_ASK_TIMEOUT = 2.0
_ASK_BRIEFLY = 0.1
_RETRY = 0.2  # s until the next question after one that nobody answered
_REFUSALS = 5  # a dead predecessor's token may take a moment to go


class RobotNode:
    """One robot id, one life after another, on one bus.

    Args:
        bus: a connection of its own.
        run: name of the run.
        robot: own id.
        patience: s, see PATIENCE.
        wait: s that there may be no world yet.
        namespace: of the own base's topics, if it must have a base; empty, as the scenario has it.
        say: takes what a person should know.
        note: takes what is worth a line in a log.

    Raises:
        JoinError: the world refuses this id.
        BusError: the world is gone, or was never there.
    """

    def __init__(
        self,
        bus: Bus,
        run: str,
        robot: int,
        *,
        patience: float = PATIENCE,
        wait: float = PATIENCE,
        namespace: str | None = None,
        say: Callable[[str], None] = lambda _: None,
        note: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.finished = False
        self.verdict = ""
        self.core: Robot | None = None
        self._bus, self._run, self._robot = bus, run, robot
        self._patience, self._wait, self._say, self._note = patience, wait, say, note
        self._alone_since = inf  # s, monotonic: since when the world's token is missing
        self._away = 0.0  # s that the world may be gone and still come back, as it said itself
        self._session = os.urandom(8).hex()
        self._lockstep = True
        self._namespace = namespace
        self._base: Base | None = None
        self._founded = False  # whether the run had begun when this robot was admitted
        self._said = ""  # the newest of what was said of the base
        self._declared = self._announced = self._over = self._noted = False
        self._doubtful = False  # whether the world may have ended this life while it was not heard
        self._refused = 0
        self._rejected: Counter[str] = Counter()
        self._peers: dict[str, PeerReader] = {}  # by the key of the State
        self._radii: dict[int, float] = {}  # of all others, m
        self._oldest: Mapping[int, int] = {}  # first incarnations in this run
        self._near: frozenset[int] = frozenset()  # who is near, or will soon be; empty if that was never said
        self._heard: set[str] = set()  # keys of States that are subscribed to
        self._said_state = self._said_command = b""  # newest, as they were sent
        self._published = self._received = 0
        self._heard_world = self._reported = time.monotonic()
        self._due = self._heard_world

    @property
    def deadline(self) -> float:
        """When `wake` wants to be called next, s, monotonic."""
        return self._due if self._base is None else min(self._due, self._base.due)

    # -- joining

    def _join(self) -> None:
        """Ask for a life, the next if there was one and it has ended. To ask without saying that it has ended
        changes nothing for one that goes on, and finds out whether it does.
        """
        ended = self.core is not None and self._ended
        health = self._health() if ended else None
        request = joining.encode_request(joining.Join(self._robot, self._session, health))
        try:
            reply = joining.decode_reply(self._ask(request))
        except (BusError, MessageError) as error:
            self._on_silence(error)
            return
        now = time.monotonic()
        self._heard_world = now
        if self._goes_on(reply):
            self._doubtful, self._due = False, now + REPORT_PERIOD
        elif isinstance(reply, joining.Wait):
            self._due = now + min(max(0.0, reply.after), self._patience)
        elif isinstance(reply, joining.Finished):
            self.verdict, self.finished = reply.verdict, True
            self._note(f"the run is over: {reply.verdict}")
        elif isinstance(reply, joining.Admission):
            self._begin(reply)
        elif isinstance(reply, joining.Refusal):
            self._refused += 1
            if self._refused >= _REFUSALS:
                raise JoinError(reply.text)
            self._due = now + 0.2

    def _goes_on(self, reply: joining.Reply) -> bool:
        """Whether this is the answer that the present life is as it was."""
        core = self.core
        if core is None or self._ended or not isinstance(reply, joining.Admission):
            return False
        return reply.incarnation == core.incarnation

    def _on_silence(self, error: Exception) -> None:
        """Nobody answers a request to join, or nobody who could be understood."""
        now = time.monotonic()
        if now <= self._heard_world + self._bearable:
            self._due = now + _RETRY  # not there yet, cut off for a moment, or the reply was lost
        elif self._over:
            self.finished = True  # the world left first, and not even the end of its token was heard
        else:
            text = f"run {self._run!r}: no world answers ({error}); is it running, under this name?"
            raise BusError(text) from error

    @property
    def _bearable(self) -> float:
        """For how long nobody may answer, s; when all is over, long only if the world said that it may be
        back."""
        if self.core is None:
            return self._wait
        return max(_ASK_TIMEOUT if self._over else self._patience, self._away)

    def _ask(self, request: bytes) -> bytes:
        # A world whose run is over may leave at any moment, and who asks does not hear that its token went.
        timeout = _ASK_BRIEFLY if self._over else _ASK_TIMEOUT
        return self._bus.ask(robot_key(self._run, self._robot, "join"), request, timeout)

    def _begin(self, admission: joining.Admission) -> None:
        self.core = Robot(admission.scenario, self._robot, admission.incarnation)
        others = [spec for spec in admission.scenario.robots if spec.id != self._robot]
        self._radii = {spec.id: spec.radius for spec in others}
        self._oldest, self._near = admission.oldest, frozenset()
        self._peers = {}
        for spec in () if admission.scenario.hears_near else others:
            self._know(spec.id, spec.radius)
        self._lockstep, self._away = admission.lockstep, admission.away
        self._founded = admission.founded
        self._refused = self._published = self._received = 0
        self._rejected.clear()
        self._commanded = True
        self._ended = self._over = self._noted = self._doubtful = False
        self._note(f"life {admission.incarnation} begins, in scenario {admission.scenario.name!r}")
        self._due = time.monotonic() + REPORT_PERIOD
        self._listen(self._peers)
        if not self._declared:
            self._declare()

    def _know(self, peer: int, radius: float) -> str:
        """Be ready to read the States of a peer; their key."""
        key = robot_key(self._run, peer, "state")
        known = self._peers.get(key)
        index = len(self._peers) if known is None else known.index
        self._peers[key] = PeerReader(self._robot, peer, radius, self._oldest.get(peer, 0), index)
        return key

    def _meet(self, roster: Roster) -> None:
        """Hear who has joined the fleet since this process was admitted."""
        assert self.core is not None
        for member in roster.members:
            peer, radius = member.robot, member.radius
            if peer == self._robot or self._radii.get(peer) == radius:
                continue
            self._radii[peer] = radius
            if self.core.hears_everybody or robot_key(self._run, peer, "state") in self._peers:
                self._listen((self._know(peer, radius),))

    def _attend(self, near: Iterable[int]) -> None:
        """Hear those who will be near, and for a while those who were."""
        before, self._near = self._near, frozenset(near)
        keys = {peer: robot_key(self._run, peer, "state") for peer in sorted(self._near | before)}
        for peer, key in keys.items():
            if peer in self._near and peer in self._radii and key not in self._peers:
                self._know(peer, self._radii[peer])
        kept = frozenset(keys.values())
        self._listen([key for key in self._peers if key in kept])
        for key in sorted(self._heard - kept):
            self._bus.unsubscribe(key)
            self._heard.discard(key)
            self._peers.pop(key, None)

    def _listen(self, keys: Iterable[str]) -> None:
        """Subscribe to peers' States, once each: a later life may know of peers that the first did not."""
        fresh = [key for key in keys if key not in self._heard]
        if fresh:
            self._bus.subscribe(*fresh)
            self._heard.update(fresh)

    def _declare(self) -> None:
        """Subscriptions before publishers before the token: whoever sees the token can rely on the rest."""
        bus, run, robot = self._bus, self._run, self._robot
        bus.watch(world_key(run, "alive"))
        bus.subscribe(robot_key(run, robot, "tick"))
        bus.subscribe(world_key(run, "summary"))
        self._tell_state = bus.publisher(STREAMS["state"], robot_key(run, robot, "state"))
        self._tell_command = bus.publisher(STREAMS["command"], robot_key(run, robot, "command"))
        self._tell_health = bus.publisher(STREAMS["health"], robot_key(run, robot, "health"))
        assert self.core is not None
        self._base = base_of(self.core.scenario, robot, self._namespace)
        if self._base is None:
            self._announce()
        else:
            bus.subscribe(*self._base.keys)
            self._tell_base = bus.foreign(self._base.tells)
        self._declared = True

    def _announce(self) -> None:
        self._bus.announce(robot_key(self._run, self._robot, "alive"))
        self._announced = True

    # -- events

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            self._on_sample(event.key, event.payload)
        elif isinstance(event, Presence):
            self._on_presence(event.alive)

    def _on_presence(self, alive: bool) -> None:
        """The world's token came or went. While it is missing nothing is executed: the robot stands still."""
        if alive:
            if self._alone_since < inf:
                self._say(f"the world of run {self._run!r} is back")
                self._doubtful, self._due = True, time.monotonic()  # nobody may have told it of its end
            self._alone_since = inf
        elif self._over and not self._away:
            self.finished = True
        else:
            self._alone_since = time.monotonic()
            self._say(f"the world of run {self._run!r} is gone; stands still")

    def _on_sample(self, key: str, payload: bytes) -> None:
        base = self._base
        if base is not None and key in base.keys:
            base.hear(key, payload, time.monotonic())
            return
        try:
            peer = self._peers.get(key)
            heard = None if peer is None else peer.read(payload)
            message = decode(key, payload) if peer is None else None
        except MessageError as error:
            self._rejected[error.reason] += 1
            return
        self._received += 1
        core = self.core
        if core is None or self._ended:
            return
        if heard is not None and peer is not None:
            if heard.incarnation >= peer.oldest:  # else it is of an earlier run
                self._on_state(core, heard)
        else:
            self._on_message(core, message)

    def _on_message(self, core: Robot, message: AnyMessage | None) -> None:
        """Anything but the State of a peer that is heard."""
        if isinstance(message, Tick):
            self._on_tick(core, message)
        elif isinstance(message, Summary):
            self._on_summary(core, message)
        elif isinstance(message, State) and core.hears_everybody:
            self._rejected["identity"] += 1  # of nobody who takes part

    def _on_summary(self, core: Robot, summary: Summary) -> None:
        try:
            core.on_summary(summary)
        except MessageError as error:
            self._rejected[error.reason] += 1
            return
        if not self._commanded and core.complete:
            self._command()

    def _on_state(self, core: Robot, state: PeerState) -> None:
        core.on_state(state)
        if not self._commanded and core.complete:
            self._command()

    def _on_tick(self, core: Robot, tick: Tick) -> None:
        self._heard_world = time.monotonic()
        if tick.over and tick.incarnation >= core.incarnation:
            self._over = True
            self._rejoin()
        elif core.has_ended(tick) or tick.incarnation > core.incarnation:
            self._rejoin()  # fenced, or replaced by another process
        elif tick.tick == core.tick:
            self._repeat()
            core.reconsider(tick)
            if not self._commanded:
                self._command_or_complain(core)
        elif tick.incarnation == core.incarnation and tick.tick > core.tick:
            if tick.roster is not None:
                self._meet(tick.roster)
            if tick.near is not None:
                self._attend(tick.near)
            self._said_state = encode(core.begin(tick, self._sense(core, tick)))
            if core.note and not self._noted:
                self._noted = True
                self._say(core.note)
            self._tell_state(self._said_state)
            self._published += 1
            self._commanded = False
            if core.complete or not self._lockstep:
                self._command()

    def _sense(self, core: Robot, tick: Tick) -> Sense | None:
        """What the own base and localisation say as a tick begins, if it has its own."""
        base = self._base
        if base is None:
            return None
        sense = base.begin(tick, self._heard_world)
        if base.begins_anew():
            core.begin_anew()
        elif core.lost and not base.note:
            base.doubt(core.note)
        return sense

    def _command(self) -> None:
        assert self.core is not None
        command = self.core.command()
        if self._base is not None:
            self._base.obey(command, time.monotonic())
        self._said_command = encode(command)
        self._tell_command(self._said_command)
        self._published += 1
        self._commanded = True
        if self._heard_world >= self._reported + REPORT_PERIOD:
            self._report()

    def _command_or_complain(self, core: Robot) -> None:
        """The world waits: say at least why there is no Command."""
        if core.complete:
            self._command()
        elif core.lacks_states:
            self._tell_command(encode(core.complaint()))

    def _repeat(self) -> None:
        """The world waits for somebody: perhaps for one who did not hear what this robot said."""
        self._tell_state(self._said_state)
        if self._commanded:
            self._tell_command(self._said_command)

    def _rejoin(self) -> None:
        """This life is over; ask for the next. What still arrives is not for this life."""
        self._ended = True
        self._report()
        self._due = time.monotonic()
        if self._base is not None:
            self._base.stand(self._due)
            self._move(self._base, self._due)

    # -- time

    def wake(self, now: float) -> None:
        base = self._base
        if base is not None and now >= base.due:
            self._move(base, now)
        if base is None or now >= self._due:
            self._look(now)

    def _move(self, base: Base, now: float) -> None:
        """Tell the own base what it has to be told by now, and people what is wrong with it."""
        for payload in base.wake(now):
            self._tell_base(payload)
        trouble = base.note
        if not self._announced and self.core is not None and not trouble:
            known = base.place()
            if known is not None and not self._founded:
                trouble = misplaced(self.core.scenario, self._robot, *known)
            if not trouble:
                self._announce()
        if trouble != self._said:
            self._said = trouble
            self._say(f"{trouble}; stands" if trouble else "its base and its localisation are sound")

    def _look(self, now: float) -> None:
        if self.core is None or self._ended or self._doubtful:
            self._join()
            return
        self._due = now + REPORT_PERIOD
        if now >= self._reported + REPORT_PERIOD:
            self._report()
        if now > self._alone_since + self._bearable:
            raise BusError(f"run {self._run!r}: the world has been gone for {self._bearable:g} s; gives up")
        if now > self._heard_world + self._patience and self._alone_since == inf:
            self._ask(b"")  # raises if nobody is there; a held clock is no reason to leave
            self._heard_world = time.monotonic()

    def _report(self) -> None:
        self._reported = time.monotonic()
        self._tell_health(encode(self._health()))

    def _health(self) -> Health:
        core = self.core
        assert core is not None
        health = core.health(self._published, self._received, dict(self._rejected))
        return replace(health, note=self._said) if self._said else health
