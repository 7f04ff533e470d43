"""Two robots on a track of a few places, and every order of events: an exhaustive breadth-first search.

The owner is on the left, the follower on the right. Whatever was once sent can arrive at any later
moment, any number of times, in any order, or never. Either robot can die and start anew at any moment, which
forgets everything but the place where it stands. Either may be fenced: that life never moves again,
though it may still talk. The world announces that to whoever lives while no newer life of the fenced robot
has joined, and it is heard sooner or later. The machines are the real ones.
"""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Iterator
from typing import Any, NamedTuple

from interpreted import interpreted

# The search looks into both ends and tries mutants of them, which what is compiled does not allow.
_line, _pair = interpreted("agents.lines.line", "agents.lines.pair")
Line, Owner, Follower = _line.Line, _pair.Owner, _pair.Follower

LINES = (0.5, 1.5, 2.5)  # offsets; places are 0, 1, 2, 3


class Bounds(NamedTuple):
    """What keeps the search finite."""

    owner_lives: int = 2
    follower_lives: int = 2
    proposals: int = 3  # numbers used in one life of the owner
    outstanding: int = 1  # unanswered proposals at once
    fences: int = 0  # lives that are fenced
    initial: bool = False  # whether the first lives begin with a line that both know


class Config(NamedTuple):
    """One state of the model: both ends, both places, everything ever sent."""

    owner: Owner
    follower: Follower
    left: int
    right: int
    offers: frozenset[tuple[int, int, int, float]]  # owner's life, follower's life, number, offset
    answers: frozenset[tuple[int, int, int, int]]  # follower's life, owner's life, held, seen
    fenced: frozenset[tuple[bool, int]] = frozenset()  # whether the owner, and which life
    downs: frozenset[tuple[bool, int, int, int]] = frozenset()  # the same, its place, the life that is told
    owner_disk: int | None = None  # place of a fenced follower, as the owner knows it
    follower_disk: int | None = None

    @property
    def owner_moves(self) -> bool:
        """Whether the owner is ready and not fenced."""
        fenced = (True, self.owner.life) in self.fenced
        return not fenced and (self.owner.agreed or self.owner_disk is not None)

    @property
    def follower_moves(self) -> bool:
        """Whether the follower is ready and not fenced."""
        fenced = (False, self.follower.life) in self.fenced
        return not fenced and (self.follower.agreed or self.follower_disk is not None)

    def key(self) -> tuple[Any, ...]:
        ends = (_frozen(self.owner), _frozen(self.follower))
        return (*ends, *self[2:])


def _frozen(end: Owner | Follower) -> tuple[Any, ...]:
    return tuple(tuple(value.items()) if isinstance(value, dict) else value for value in vars(end).values())


def _copied(end: Any) -> Any:
    twin = copy.copy(end)
    for name, value in vars(end).items():
        if isinstance(value, dict):
            setattr(twin, name, dict(value))
    return twin


def owner_span(config: Config) -> int:
    """Rightmost place that the owner may reach without another message."""
    if not config.owner_moves:
        return config.left
    disk = () if config.owner_disk is None else (config.owner_disk - 1,)
    return min([int(line.offset) for line in config.owner.obeyed] + [*disk], default=3)


def follower_span(config: Config) -> int:
    """Leftmost place that the follower may reach without another message."""
    if not config.follower_moves:
        return config.right
    disk = () if config.follower_disk is None else (config.follower_disk + 1,)
    return max([int(line.offset) + 1 for line in config.follower.obeyed] + [*disk], default=0)


def holds(config: Config) -> bool:
    """The invariant: a place line separates all that either may do, and both are where they may be."""
    left, right = owner_span(config), follower_span(config)
    return config.left <= left < right <= config.right


def successors(config: Config, bounds: Bounds) -> Iterator[Config]:
    """Every state that one event leads to."""
    yield from _moves(config)
    yield from _speech(config, bounds)
    yield from _deliveries(config)
    yield from _restarts(config, bounds)
    yield from _fences(config, bounds)


def _moves(config: Config) -> Iterator[Config]:
    for step in (-1, 1):
        if config.owner_moves and 0 <= config.left + step <= owner_span(config):
            yield config._replace(left=config.left + step)
        if config.follower_moves and follower_span(config) <= config.right + step <= 3:
            yield config._replace(right=config.right + step)


def _speech(config: Config, bounds: Bounds) -> Iterator[Config]:
    end = config.owner
    if end.met and end.number < bounds.proposals and len(end.proposed) < bounds.outstanding:
        for offset in LINES:
            if config.left <= offset:
                owner = _copied(end)
                number = owner.propose(Line(1.0, 0.0, offset))
                offer = (owner.life, owner.peer_life, number, offset)
                yield config._replace(owner=owner, offers=config.offers | {offer})
    follower = config.follower
    if follower.seen:
        answer = (follower.life, follower.peer_life, follower.held_number, follower.seen)
        if answer not in config.answers:
            yield config._replace(answers=config.answers | {answer})


def _deliveries(config: Config) -> Iterator[Config]:
    for peer_life, life, number, offset in config.offers:
        follower = _copied(config.follower)
        follower.hear(
            peer_life, life, number, Line(1.0, 0.0, offset), lambda line: config.right >= line.offset
        )
        disk = None if follower.agreed else config.follower_disk
        yield config._replace(follower=follower, follower_disk=disk)
    for peer_life, life, held, seen in config.answers:
        owner = _copied(config.owner)
        owner.hear(peer_life, life, held, seen)
        yield config._replace(owner=owner, owner_disk=None if owner.agreed else config.owner_disk)
    for life in range(1, config.follower.life + 1):  # a State that says nothing of lines
        owner = _copied(config.owner)
        owner.meet(life)
        yield config._replace(owner=owner)
    for life in range(1, config.owner.life + 1):
        follower = _copied(config.follower)
        follower.meet(life)
        yield config._replace(follower=follower)


def _restarts(config: Config, bounds: Bounds) -> Iterator[Config]:
    if config.owner.life < bounds.owner_lives:
        owner = type(config.owner)(config.owner.life + 1)
        yield _announced(config._replace(owner=owner, owner_disk=None))
    if config.follower.life < bounds.follower_lives:
        follower = type(config.follower)(config.follower.life + 1)
        yield _announced(config._replace(follower=follower, follower_disk=None))


def _fences(config: Config, bounds: Bounds) -> Iterator[Config]:
    if len(config.fenced) < bounds.fences:
        yield _announced(config._replace(fenced=config.fenced | {(True, config.owner.life)}))
        yield _announced(config._replace(fenced=config.fenced | {(False, config.follower.life)}))
    for is_owner, life, place, told in config.downs:
        if is_owner and told == config.follower.life and life >= config.follower.peer_life:
            follower = _copied(config.follower)
            follower.bury(life)
            yield config._replace(follower=follower, follower_disk=place)
        elif not is_owner and told == config.owner.life and life >= config.owner.peer_life:
            owner = _copied(config.owner)
            owner.bury(life)
            yield config._replace(owner=owner, owner_disk=place)


def _announced(config: Config) -> Config:
    """Whoever lives now is told of the other's present life, if that is fenced."""
    downs = set(config.downs)
    if (True, config.owner.life) in config.fenced:
        downs.add((True, config.owner.life, config.left, config.follower.life))
    if (False, config.follower.life) in config.fenced:
        downs.add((False, config.follower.life, config.right, config.owner.life))
    return config._replace(downs=frozenset(downs))


class Search(NamedTuple):
    """What a search found."""

    visited: int
    counterexample: Config | None


def search(
    bounds: Bounds, owner: type[Owner] = Owner, follower: type[Follower] = Follower, most: int = 2_000_000
) -> Search:
    """Visit all states reachable within `bounds`, nearest first, until one breaks the invariant."""
    line = Line(1.0, 0.0, 1.5) if bounds.initial else None
    peer_life = 1 if bounds.initial else 0
    start = Config(owner(1, line, peer_life), follower(1, line, peer_life), 0, 3, frozenset(), frozenset())
    seen = {start.key()}
    queue = deque([start])
    while queue:
        config = queue.popleft()
        if not holds(config):
            return Search(len(seen), config)
        for after in successors(config, bounds):
            key = after.key()
            if key not in seen:
                seen.add(key)
                queue.append(after)
        if len(seen) > most:
            raise AssertionError(f"the model is larger than {most} states: {bounds}")
    return Search(len(seen), None)
