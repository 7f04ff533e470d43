"""One robot process's session with the world: admission, sign of life, and a bounded wait for its return."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from math import inf
from typing import Final, final

from protocol import joining
from protocol.bus.bus import Bus
from protocol.errors import BusError, JoinError, MessageError
from protocol.keys import robot_key, session_of
from protocol.messages import Health

Emit = Callable[[str], None]
Read = Callable[[bytes], joining.JoinReply]

PATIENCE: Final = 10.0  # s without a message of the world before it is asked, or before giving up
RETRY: Final = 0.2  # s until the next question after one that was of no use
_TIMEOUT = 2.0  # s that a question may take
_BRIEF = 0.1  # s that it may take when the run is over: the end of the world's token may have been missed
_REFUSALS = 5  # a dead predecessor's token may take a moment to go
_NEWS = 2.0  # s that the world may be gone before a warning: a launcher that ends the run ends robots, too


@final
class WorldSession:
    """Requests to join, and the world's token.

    Args:
        wait: longest time without a world, s; PATIENCE at least, once it has been admitted.
        read: decodes an answer to a request to join; its result is never changed.
    """

    def __init__(
        self, bus: Bus, run: str, robot: int, wait: float, warn: Emit, read: Read = joining.decode_reply
    ) -> None:
        self.session = os.urandom(8).hex()  # of this process
        self.epoch = 0  # of the coordinator that admitted this process last, 0 for none
        self.grace = 0.0  # s after which the world may still return, as it announced; 0 if it never does
        self.heard = time.monotonic()  # s, monotonic: when the last message of the world arrived
        self.back = False  # whether a world has come back, so that this life may have ended meanwhile
        self._bus, self._run, self._robot, self._warn, self._read = bus, run, robot, warn, read
        self._present: set[str] = set()  # sessions of the worlds whose tokens are there
        self._wait, self._bearable, self._timeout = wait, wait, _TIMEOUT  # s; without an answer; of a request
        self._gone = inf  # s, monotonic: loss of its token
        self._told_gone = False  # whether the operator was warned
        self._refused = 0
        self._probed = -inf  # s, monotonic: newest request to a silent world
        self._strange = -inf  # s, monotonic: first reply of another run since the world was heard

    def ask(self, health: Health | None, *, begun: bool = False) -> joining.JoinReply | None:
        """Request to join, with `health` if an incarnation of this process has ended; without it the reply
        only confirms the present life. Returns the reply; None to ask again a little later.

        Args:
            begun: whether the run of this process has begun: then its world may return beside one of another
                run, as after a cut link.

        Raises:
            JoinError: the world refuses this id.
            BusError: the world is lost, or was never present, or is one of another run.
        """
        request = joining.encode_request(joining.Join(self._robot, self.session, health, self.epoch))
        try:
            reply = self._answer(request)
        except (BusError, MessageError) as error:
            self._probed = time.monotonic() - PATIENCE + _TIMEOUT  # it, or the reply, may be lost
            if time.monotonic() <= self.heard + self._bearable:
                return None  # not yet present, briefly disconnected, or the reply was lost
            text = f"run {self._run!r}: no world answers: {error}"
            raise BusError(text) from error
        if isinstance(reply, joining.OtherRun):
            if self._strange < self.heard:
                self._strange = time.monotonic()
            if begun and time.monotonic() <= self._strange + max(PATIENCE, self.grace):
                return None
            raise BusError(f"another run has the name {self._run!r} now; start this process again for it")
        self.heard = time.monotonic()
        if isinstance(reply, joining.Refusal):
            self._refused += 1
            if self._refused >= _REFUSALS:
                raise JoinError(reply.text, self._robot)
            return None
        self._refused = 0
        return reply

    def _answer(self, request: bytes) -> joining.JoinReply:
        """The reply of the only coordinator, or of its own; raises BusError if two others reply.

        Worlds of another run do not count beside one of its own, which may be the successor of the last.
        """
        key = robot_key(self._run, self._robot, "join")
        replies = [self._read(each) for each in self._bus.ask(key, request, self._timeout)]
        mine: list[joining.JoinReply] = [each for each in replies if not isinstance(each, joining.OtherRun)]
        mine = mine or replies[:1]
        if len(mine) > 1:
            mine = [each for each in mine if isinstance(each, joining.Admission) and each.epoch == self.epoch]
        if len(mine) != 1:
            raise BusError("several worlds of this run answer, end all but one")
        return mine[0]

    def on_tick(self) -> None:
        """Note a Tick of its own world, which is there whatever its token says."""
        self.heard, self._gone = time.monotonic(), inf

    def admitted(self, admission: joining.Admission) -> None:
        """Note the admission of an incarnation."""
        self.epoch, self._gone, self._told_gone = admission.epoch, inf, False
        self.grace = admission.grace
        self._bearable, self._timeout = max(PATIENCE, self._wait, admission.grace), _TIMEOUT

    def over(self) -> None:
        """The run is over: a world that leaves is awaited only if it may be back."""
        self._bearable, self._timeout = max(_TIMEOUT, self.grace), _BRIEF

    def is_own(self, session: str) -> bool:
        """Whether a token is that of the coordinator which admitted this process."""
        return session == session_of(self.epoch)

    def on_token(self, session: str, alive: bool) -> None:
        """A world's token appeared or disappeared. Without its own the robot stands, and joins another."""
        was_gone = self._gone < inf
        (self._present.add if alive else self._present.discard)(session)
        if self.is_own(session):
            self._gone = inf if alive else time.monotonic()
        returns = was_gone and self._gone == inf
        # Its own may have disappeared before this process saw it.
        is_replaced = bool(self._present) and session_of(self.epoch) not in self._present
        if not (returns or is_replaced):
            return
        if self._told_gone:
            which = "is back" if returns else "has been started again"
            self._warn(f"the world of run {self._run!r} {which}")
        self.back, self._told_gone = True, False

    def check(self, now: float) -> bool:
        """Check the presence of the world at `now`, s. Returns whether to ask a silent one once: it confirms
        the present life, and its successor begins another. Raises BusError after a long absence.
        """
        if now > self._gone + _NEWS and not self._told_gone:
            self._told_gone = True
            self._warn(f"the world of run {self._run!r} is gone; the robot stands still")
        if now > self._gone + self._bearable:
            raise BusError(f"run {self._run!r}: the world has been gone for {self._bearable:g} s; gives up")
        is_due = now > max(self.heard, self._probed) + PATIENCE
        if is_due:
            self._probed = now
        return is_due
