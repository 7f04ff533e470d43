"""All the lines of one robot: what it must obey now, what it says about them.

Messages carry only what is open. A proposal is repeated in every State until it is answered. An
answer is said when a proposal was heard, in the States of the next few ticks. That suffices: an owner
without an unanswered proposal needs no answer; one that has any repeats it for ever, so if every
answer so far was lost, the next repetition that arrives brings about another.
"""

from __future__ import annotations

from collections.abc import Mapping

from agents.lines.fixed_disk import FixedDisk
from agents.lines.line import ROUNDING, HalfPlane, Line
from agents.lines.pair import Follower, Owner
from agents.lines.placement import Disk, is_idle, place
from protocol.messages import Answer, Down, Proposal, State

ANSWER_TICKS = 3  # an answer stands in this many States after the proposal was last heard


class Bond:
    """One pair: the own end of the line, the peer as last heard, the disk it left if it is fenced."""

    __slots__ = ("answers_left", "disk", "end", "owns", "radius", "sides", "state")

    def __init__(self, life: int, owns: bool, radius: float) -> None:
        self.owns = owns
        self.end: Owner | Follower = Owner(life) if owns else Follower(life)
        self.radius = radius  # of the peer, m
        self.state: State | None = None
        self.disk: FixedDisk | None = None
        self.sides: tuple[HalfPlane, ...] = ()  # of the obeyed lines, for the own centre
        self.answers_left = 0

    @property
    def ready(self) -> bool:
        """Whether the peer is surely behind something that this robot obeys."""
        return self.end.agreed or (self.disk is not None and self.disk.half_plane is not None)

    @property
    def all_sides(self) -> tuple[HalfPlane, ...]:
        """Where the own centre must stay because of this peer."""
        if self.disk is None or self.disk.half_plane is None:
            return self.sides
        return (*self.sides, self.disk.half_plane)

    def renew(self, own_radius: float) -> None:
        """What is obeyed has changed."""
        self.sides = tuple(line.side(own_radius, self.owns) for line in self.end.obeyed)
        if self.end.agreed:
            self.disk = None


class Ledger:
    """Every separating line of one robot.

    One tick is: `locate`, `hear` what has come in, `speak` for the State; `hear` the States of this
    tick, then `ready` and `half_planes` for the velocity. No command is outstanding at these moments.

    Args:
        robot: own id.
        incarnation: own life.
        radii: radius of every robot, m, own included.
        reach: the most that a robot moves in a tick, m.
    """

    def __init__(self, robot: int, incarnation: int, radii: Mapping[int, float], reach: float) -> None:
        self._robot = robot
        self._incarnation = incarnation
        self._radius = radii[robot]
        self._reach = reach
        self._bonds = {
            peer: Bond(incarnation, robot < peer, radii[peer]) for peer in sorted(radii) if peer != robot
        }
        self._tick = 0
        self._x = self._y = 0.0
        self._bound = float("inf")

    def locate(self, tick: int, position: tuple[float, float], bound: float) -> None:
        """Take the own position (m), at most `bound` (m) from the truth, at the start of `tick`."""
        self._tick = tick
        self._x, self._y = position
        self._bound = bound
        for bond in self._bonds.values():
            if bond.disk is not None:
                bond.disk.renew(self._x, self._y, bound)

    def hear(self, state: State) -> None:
        """Process what a peer's State says about the common line; old or repeated ones do no harm."""
        bond = self._bonds.get(state.robot)
        if bond is None or state.incarnation < bond.end.peer_life:
            return
        if state.incarnation > bond.end.peer_life:
            bond.state = None
        bond.end.meet(state.incarnation)
        if bond.state is None or state.tick > bond.state.tick:
            bond.state = state
        end = bond.end
        if isinstance(end, Owner):
            self._hear_answers(bond, end, state)
        else:
            self._hear_proposals(bond, end, state)

    def peer_down(self, down: Down) -> None:
        """A peer's life is fenced: its disk stands still. Old news does no harm, nor repeating it."""
        bond = self._bonds.get(down.robot)
        if bond is None or down.incarnation < bond.end.peer_life:
            return
        bond.disk = FixedDisk(*down.position, bond.radius, self._radius, bond.all_sides)
        bond.disk.renew(self._x, self._y, self._bound)
        bond.end.bury(down.incarnation)
        bond.state = None
        bond.renew(self._radius)

    def removed(self, peer: int) -> None:
        """The operator has taken a peer out of the workspace."""
        self._bonds.pop(peer, None)

    @property
    def ready(self) -> bool:
        """Whether there is a line with every live peer; a robot that is not ready must stand still."""
        return all(bond.ready for bond in self._bonds.values())

    def half_planes(self) -> list[HalfPlane]:
        """Where the estimated own centre must stay; radius and error bound are subtracted."""
        margin = self._bound + 2.0 * ROUNDING
        planes = []
        for bond in self._bonds.values():
            for nx, ny, limit in bond.all_sides:
                planes.append(HalfPlane(nx, ny, limit - margin))
        return planes

    def sides(self) -> tuple[tuple[int, float, float, float], ...]:
        """All obeyed lines for a monitor: peer, nx, ny, limit; the own disk keeps n.x <= limit."""
        return tuple(
            (peer, nx, ny, limit + self._radius)
            for peer, bond in self._bonds.items()
            for nx, ny, limit in bond.all_sides
        )

    def speak(self, desired: tuple[float, float]) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """What this tick's State says about lines; `desired` is the velocity that the law asks for, m/s."""
        me = Disk(self._x, self._y, self._radius + self._bound, *desired)
        proposals: list[Proposal] = []
        answers: list[Answer] = []
        for peer, bond in self._bonds.items():
            end = bond.end
            if isinstance(end, Owner):
                if not end.proposed:
                    self._consider(bond, end, me)
                for number, (nx, ny, offset) in end.proposed.items():
                    proposals.append(Proposal(peer, end.peer_life, number, nx, ny, offset))
            elif bond.answers_left:
                bond.answers_left -= 1
                answers.append(Answer(peer, end.peer_life, end.held_number, end.seen))
        return tuple(proposals), tuple(answers)

    def _hear_answers(self, bond: Bond, end: Owner, state: State) -> None:
        for answer in state.answers:
            if answer.peer == self._robot and end.hear(
                state.incarnation, answer.peer_incarnation, answer.held, answer.seen
            ):
                bond.renew(self._radius)

    def _hear_proposals(self, bond: Bond, end: Follower, state: State) -> None:
        for offer in state.proposals:
            if offer.peer == self._robot:
                bond.answers_left = ANSWER_TICKS
                line = Line(offer.nx, offer.ny, offer.offset)
                if end.hear(
                    state.incarnation, offer.peer_incarnation, offer.number, line, self._follower_fits
                ):
                    bond.renew(self._radius)

    def _owner_fits(self, line: Line) -> bool:
        """Whether the own disk surely satisfies a line now, on the owner's side."""
        return line.is_unit and self._is_inside(line.side(self._radius, owner=True))

    def _follower_fits(self, line: Line) -> bool:
        """The same on the follower's side."""
        return line.is_unit and self._is_inside(line.side(self._radius, owner=False))

    def _is_inside(self, side: HalfPlane) -> bool:
        return side.slack(self._x, self._y) >= self._bound + ROUNDING

    def _consider(self, bond: Bond, end: Owner, me: Disk) -> None:
        """Propose a new line if the pair needs one."""
        state = bond.state
        if not end.met or state is None or state.position is None:
            return
        peer = Disk(*state.position, bond.radius + state.bound, *state.desired)
        held = end.held
        horizon = (2 * max(0, self._tick - state.tick) + 2) * self._reach
        if held is not None and is_idle(held, me, peer, horizon):
            return
        line = place(me, peer)
        if line is not None and self._owner_fits(line):
            end.propose(line)
            bond.renew(self._radius)
