"""A peer's State as a robot keeps it, and its decoder.

Most proposals and answers in a State concern other pairs: the decoder checks them, and creates no objects for
them. By `protocol.codec` and `addressed_to` alone a State takes 1.5 us instead of 0.2: to a robot among 32
that would be another 45 us a tick, as much as all the rest of its step takes.
"""

from __future__ import annotations

import math
from typing import Final, final

import msgspec
from mypy_extensions import mypyc_attr

from protocol.codec import Cursor, keeps_newest, read
from protocol.errors import MessageError
from protocol.keys import STREAMS
from protocol.line import UNIT
from protocol.messages import HIGHEST_ID, LARGEST, Answer, Claim, Proposal, State, Vector
from protocol.scenario.model import Scenario


@mypyc_attr(acyclic=True)
class Peer:
    """A disk as a robot knows it: centre and radius in m, gamma_j = |b_j - g_j|^2 in m^2 (0 if fixed)."""

    def __init__(self, x: float, y: float, radius: float, gamma: float) -> None:
        self.x, self.y, self.radius, self.gamma = x, y, radius, gamma


@final
@mypyc_attr(acyclic=True)
class PeerState(Peer):
    """A State as one receiver needs it; the other fields are those of `protocol.messages.State`, whose
    numbers are objects: compiled, a pass over 63 peers takes 1.7 us over messages, and 0.1 us over these.
    """

    def __init__(
        self,
        robot: int,
        incarnation: int,
        tick: int,
        placed: bool,
        x: float,
        y: float,
        bound: float,
        gamma: float,
        slice_norm: float,
        vx: float,
        vy: float,
        proposals: tuple[Proposal, ...] = (),
        answers: tuple[Answer, ...] = (),
        *,
        radius: float = 0.0,
        claim: Claim | None = None,
    ) -> None:
        self.robot, self.incarnation, self.tick = robot, incarnation, tick
        self.placed = placed  # whether the peer knows its position
        self.x, self.y = x, y  # its estimate of the position, m; 0 unless `placed`
        self.radius = radius  # the peer's, m; see `size`
        self.bound, self.gamma, self.slice = bound, gamma, slice_norm
        self.vx, self.vy = vx, vy  # desired velocity of its law, m/s
        self.proposals, self.answers = proposals, answers
        self.claim = claim
        self.transit = 0  # age of the State when it could be used first, ticks
        self.moved_x = self.moved_y = 0.0  # displacement per tick from the State before to this one, m

    def follow(self, before: PeerState | None, tick: int) -> bool:
        """Replace the State received before, in the `tick` that begins or has begun; False if that one is of
        the same or a later tick, or of a later life."""
        if before is not None and self.incarnation <= before.incarnation:
            if self.incarnation < before.incarnation or self.tick <= before.tick:
                return False
            if self.placed and before.placed:
                ticks = self.tick - before.tick
                self.moved_x, self.moved_y = (self.x - before.x) / ticks, (self.y - before.y) / ticks
            else:
                self.moved_x, self.moved_y = before.moved_x, before.moved_y
        self.transit = tick + 1 - self.tick
        return True

    def size(self, listed: float) -> None:
        """Set the radius, m, as the State is delivered: that of the roster, or the larger one of its
        claim."""
        self.radius = listed if self.claim is None else max(listed, self.claim.radius)

    @property
    def position(self) -> Vector | None:
        """As in the State, m."""
        return (self.x, self.y) if self.placed else None

    @property
    def desired(self) -> Vector:
        """As in the State, m/s."""
        return self.vx, self.vy


@final
class Plausible:  # no NamedTuple: compiled, `allows` of one takes as long as to read the whole State
    """Bounds of a State's numbers in a scenario; a robot that sends numbers beyond them is faulty or lies.

    Args:
        place: of the absolute value of each coordinate, m.
        bound: m.
        gamma: m^2.
        part: radius of the largest part, m; 0 if there is none.
    """

    def __init__(self, place: float, bound: float, gamma: float, part: float) -> None:
        self.place, self.bound, self.gamma, self.part = place, bound, gamma, part

    def allows(self, state: PeerState) -> bool:
        """Whether a State is within the bounds."""
        place = self.place
        near = -place <= state.x <= place and -place <= state.y <= place
        return near and state.bound <= self.bound and state.gamma <= self.gamma

    def locates(self, position: Vector, bound: float) -> bool:
        """Whether a position, m, and its error bound, m, are within the bounds."""
        return abs(position[0]) <= self.place and abs(position[1]) <= self.place and bound <= self.bound


@keeps_newest
def plausible(scenario: Scenario) -> Plausible:
    """The bounds of a scenario: twice the extent of its workspace."""
    around = scenario.workspace.shape.around
    reach = math.hypot(around.x, around.y) + around.radius
    part = max((each.radius for each in scenario.parts), default=0.0)
    return Plausible(2.0 * reach, 4.0 * reach, (4.0 * reach) ** 2, part)


def addressed_to(robot: int, state: State, radius: float = 0.0) -> PeerState:
    """A State as `robot` needs it: without proposals and answers to other robots."""
    life, place = (state.robot, state.incarnation, state.tick), state.position or (0.0, 0.0)
    sizes = state.bound, state.gamma, state.slice
    proposals = tuple([each for each in state.proposals if each.peer == robot])
    answers = tuple([each for each in state.answers if each.peer == robot])
    placed = state.position is not None
    found = PeerState(*life, placed, *place, *sizes, *state.desired, proposals, answers, claim=state.claim)
    found.size(radius)
    return found


_COMPILED: Final = not __file__.endswith(".py")  # uncompiled, a cursor is slower than msgspec
_LIMIT: Final = STREAMS["state"].limit
_ANY: Final = Plausible(LARGEST, LARGEST, LARGEST**2, LARGEST)
_FIELDS = 1 + len(State.__struct_fields__)  # the tag and all others


@final
class PeerReader:
    """Decodes the payloads of the state key of `peer`, for `robot`; `epoch` is its coordinator's."""

    def __init__(self, robot: int, peer: int, epoch: int = 0, limits: Plausible = _ANY) -> None:
        self._robot, self._peer, self._epoch = robot, peer, epoch
        self._limits = limits
        whole = msgspec.msgpack.encode([State.__struct_config__.tag, peer, *[None] * (_FIELDS - 2)])
        self._begin = whole[: 2 - _FIELDS]

    def read(self, payload: bytes) -> PeerState:
        """The State in `payload`, as this robot needs it.

        Raises MessageError if it is malformed, another robot's, or out of bounds in any entry, including
        those for other robots: all receivers refuse the same States, so the sender is excluded.
        """
        try:
            state = self._usual(payload) if _COMPILED else None
        except IndexError:
            state = None
        return self._any(payload) if state is None else state

    def _usual(self, payload: bytes) -> PeerState | None:
        """A valid State in the encoding that libraries write; None, or IndexError, for anything else."""
        if len(payload) > _LIMIT or not payload.startswith(self._begin):
            return None
        cursor = Cursor(payload, len(self._begin))
        incarnation, tick = cursor.count(), cursor.count()
        placed, x, y = not cursor.none(), 0.0, 0.0
        if placed:
            cursor.enter(2)
            x, y = cursor.number(), cursor.number()
        bound, gamma, slice_norm = cursor.number(), cursor.number(), cursor.number()
        cursor.enter(2)
        vx, vy = cursor.number(), cursor.number()
        if cursor.count() != self._epoch:
            return None
        proposals, answers = self._proposals(cursor), self._answers(cursor)
        if not cursor.none():
            return None
        if cursor.at != len(payload) or bound < 0.0 or gamma < 0.0 or slice_norm < 0.0:
            return None
        if not (slice_norm <= LARGEST and abs(vx) <= LARGEST and abs(vy) <= LARGEST):
            return None
        state = PeerState(
            self._peer, incarnation, tick, placed, x, y, bound, gamma, slice_norm, vx, vy, proposals, answers
        )
        return state if self._limits.allows(state) else None

    def _proposals(self, cursor: Cursor) -> tuple[Proposal, ...]:
        found: tuple[Proposal, ...] = ()
        for _ in range(cursor.array()):
            cursor.enter(6)
            peer, binding, number = _identity(cursor), cursor.count(), cursor.count()
            nx, ny, offset = cursor.number(), cursor.number(), cursor.number()
            if not (abs(nx) <= UNIT and abs(ny) <= UNIT and abs(offset) <= LARGEST):
                raise IndexError("no line")
            if peer == self._robot:
                found = (*found, Proposal(peer, binding, number, nx, ny, offset))
        return found

    def _answers(self, cursor: Cursor) -> tuple[Answer, ...]:
        found: tuple[Answer, ...] = ()
        for _ in range(cursor.array()):
            cursor.enter(4)
            peer, binding, held, seen = _identity(cursor), cursor.count(), cursor.count(), cursor.count()
            if peer == self._robot:
                found = (*found, Answer(peer, binding, held, seen))
        return found

    def _any(self, payload: bytes) -> PeerState:
        message = read("state", self._peer, payload)
        assert isinstance(message, State)
        if message.epoch != self._epoch:
            raise MessageError("epoch", f"state: of epoch {message.epoch}, this robot is of {self._epoch}")
        state = addressed_to(self._robot, message)
        if not self._limits.allows(state):
            raise MessageError("shape", f"state of robot {self._peer}: it cannot be where it says")
        if state.claim is not None and state.claim.radius > self._limits.part:
            state.claim = msgspec.structs.replace(state.claim, radius=self._limits.part)
        return state


def _identity(cursor: Cursor) -> int:
    robot = cursor.count()
    if not 1 <= robot <= HIGHEST_ID:
        raise IndexError("no robot's id")
    return robot
