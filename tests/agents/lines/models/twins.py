"""Copies of the product's rosters and ledgers, to be changed independently, and what tells ledgers apart."""

from __future__ import annotations

from typing import Any


def twin_of(thing: Any) -> Any:
    """Shallow, and faster than `copy`."""
    kind = type(thing)
    twin = kind.__new__(kind)
    twin.__dict__.update(thing.__dict__)
    return twin


def twin_of_roster(roster: Any) -> Any:
    """Of the coordinator's."""
    twin = twin_of(roster)
    twin._members, twin._kept = dict(roster._members), dict(roster._kept)
    return twin


def twin_of_ledger(ledger: Any) -> Any:
    """Of `SeparatingLines`, with all pairs."""
    twin = twin_of(ledger)
    twin._pairs = {peer: _twin_of_pair(pair) for peer, pair in ledger._pairs.items()}
    twin._each = twin._talking = list(twin._pairs.values())
    return twin


def _twin_of_pair(pair: Any) -> Any:
    kind = type(pair)
    twin = kind.__new__(kind)
    for name in kind.__slots__:
        setattr(twin, name, getattr(pair, name))
    twin.end = twin_of(pair.end)
    if pair.owns:
        twin.end.proposed = dict(pair.end.proposed)
    if pair.disk is not None:
        twin.disk = twin_of(pair.disk)
    return twin


def frozen(ledger: Any) -> tuple[Any, ...]:
    """Equal for ledgers that nothing can tell apart."""
    return ledger._disturbed, tuple(_frozen_pair(pair) for pair in ledger._each)


def _frozen_pair(pair: Any) -> tuple[Any, ...]:
    """All that can matter later. What follows from the rest, or only moves robots elsewhere, is left out."""
    end, disk, state = pair.end, pair.disk, pair.state
    side = None if disk is None or disk.half_plane is None else (disk.half_plane.nx, disk.half_plane.limit)
    return (
        tuple(tuple(value.items()) if isinstance(value, dict) else value for value in vars(end).values()),
        tuple((side.nx, side.limit) for side in pair.line_half_planes),
        None if disk is None else (disk.shape.x, side),
        None if state is None else state.incarnation,
        pair.heard,
        pair.excused,
    )
