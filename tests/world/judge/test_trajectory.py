"""The digest of a trajectory: its definition, however it was added to, and what is kept of a long one."""

from __future__ import annotations

import pickle
import struct
from hashlib import sha256

import pytest
from hypothesis import given
from hypothesis import strategies as st

from world.judge import trajectory
from world.judge.trajectory import TrajectoryDigest

LINK = 8
IDS = (3, 5)


@pytest.fixture(autouse=True, scope="module")
def _short_links() -> object:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trajectory, "LINK", LINK)
        yield


def rows(tick: int) -> list[tuple[float, float]]:
    return [(0.1 * tick, 0.2), (-0.1, 0.3 * tick)]


def bits(first: int, last: int) -> bytes:
    return b"".join(
        struct.pack("<4d", tick, robot, *place)
        for tick in range(first, last + 1)
        for robot, place in zip(IDS, rows(tick), strict=True)
    )


@given(last=st.integers(1, 30), batch=st.integers(1, 12))
def test_it_begins_anew_after_every_link(last: int, batch: int) -> None:
    digest = TrajectoryDigest(IDS)
    for first in range(0, last + 1, batch):
        ticks = range(first, min(first + batch, last + 1))
        digest.add(ticks, [rows(tick) for tick in ticks])
    expected, begin = b"", 0
    while begin <= last:
        end = begin + LINK if begin == 0 else begin + LINK - 1
        expected = sha256(expected + bits(begin, min(end, last))).digest()
        begin = end + 1
    assert digest.hexdigest() == expected.hex()


@given(links=st.integers(1, 3), after=st.integers(0, 20))
def test_at_a_link_it_is_kept_in_a_few_bytes(links: int, after: int) -> None:
    whole, kept = TrajectoryDigest(IDS), TrajectoryDigest(IDS)
    for tick in range(links * LINK + 1):
        whole.add([tick], [rows(tick)])
        kept.add([tick], [rows(tick)])
    kept = pickle.loads(pickle.dumps(kept))
    for tick in range(links * LINK + 1, links * LINK + 1 + after):
        whole.add([tick], [rows(tick)])
        kept.add([tick], [rows(tick)])
    assert kept.hexdigest() == whole.hexdigest()
