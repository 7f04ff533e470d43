"""The digest of a trajectory: its definition, however it was added to."""

from __future__ import annotations

import struct
from hashlib import sha256

from hypothesis import given
from hypothesis import strategies as st

from world.judge.record import TrajectoryDigest

IDS = (3, 5)


def rows(tick: int) -> list[tuple[float, float]]:
    return [(0.1 * tick, 0.2), (-0.1, 0.3 * tick)]


@given(begin=st.integers(0, 9), last=st.integers(10, 30), batch=st.integers(1, 12))
def test_it_is_of_four_doubles_a_tick_and_robot(begin: int, last: int, batch: int) -> None:
    digest = TrajectoryDigest(IDS)
    for first in range(begin, last + 1, batch):
        ticks = range(first, min(first + batch, last + 1))
        digest.add(ticks, [rows(tick) for tick in ticks])
    expected = b"".join(
        struct.pack("<4d", tick, robot, *place)
        for tick in range(begin, last + 1)
        for robot, place in zip(IDS, rows(tick), strict=True)
    )
    assert digest.hexdigest() == sha256(expected).hexdigest()
