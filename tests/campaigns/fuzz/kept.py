"""What a fleet keeps on disk, damaged or made up: the world's checkpoint, and recordings.

A checkpoint says when, and since which start of the machine: what is drawn from it differs each time.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import msgspec

from deploy.run.local import LocalFleet
from deploy.telemetry.recording.reader import read
from protocol.codec import DAMAGED
from protocol.errors import JournalError, RecordingError, UsageError
from protocol.scenario.model import Time
from tests.campaigns.fuzz.mutation import Target, damaged_bytes, damaged_tree
from tests.deploy.telemetry.recording.recorded import record
from tests.world.driving import two
from world.judge import trajectory
from world.shell.persistence import records
from world.shell.persistence.journal import Journal
from world.shell.persistence.replay import resume

_SCENARIO = two()
_TICKS = 12


@cache
def _temporary() -> TemporaryDirectory[str]:
    memory = "/dev/shm"
    return TemporaryDirectory(prefix="disknav-fuzz-", dir=memory if Path(memory).is_dir() else None)


def folder() -> Path:
    """A scratch folder that goes with this process."""
    return Path(_temporary().name)


@cache
def _journal() -> bytes:
    """That of a run in its first ticks, which begins with a snapshot."""
    path = folder() / "valid"
    Journal.create(path, "local", _SCENARIO)
    with patch.object(trajectory, "LINK", _TICKS // 2):
        fleet = LocalFleet(_SCENARIO, journal=path)
        fleet.network.run(lambda: fleet.world.world.tick >= _TICKS)
    fleet.kill_world()
    return path.read_bytes()


@cache
def _payloads() -> list[bytes]:
    return [payload for _, payload, _ in records.records(folder() / "valid")]


def _draw_journal(rng: Random) -> bytes:
    """Damage to the bytes, or records that are whole and say something else."""
    valid = _journal()
    if rng.randrange(8) == 0:
        return valid
    if rng.randrange(4) == 0:
        return damaged_bytes(valid, valid[::-1], rng)
    payloads = list(_payloads())
    for _ in range(rng.randint(1, 3)):
        place = rng.randrange(len(payloads)) if rng.randrange(8) else 0
        match rng.randrange(4):
            case 0 if place:
                del payloads[place]
            case 1 if place:
                payloads.insert(place, rng.choice(payloads[1:]))
            case 2:
                payloads[place] = damaged_bytes(payloads[place], rng.choice(payloads), rng)
            case _:
                payloads[place] = _lied(payloads[place], rng)
        if len(payloads) < 2:
            break
    return records.MAGIC + b"".join(map(records.record, payloads))


def _lied(payload: bytes, rng: Random) -> bytes:
    try:
        tree: Any = msgspec.msgpack.decode(payload)
    except DAMAGED:  # by what was changed before
        return payload
    return msgspec.msgpack.encode(damaged_tree(tree, rng))


def _read_journal(drawn: bytes) -> bool:
    path = folder() / "journal"
    path.write_bytes(drawn)
    journal = Journal(path, "local", _SCENARIO)
    try:
        resume(journal, _SCENARIO)
    finally:
        journal.remove()
    return True


@cache
def _recording() -> bytes:
    path = folder() / "valid.mcap"
    record(path, time=Time(limit=0.2))
    return path.read_bytes()


def _draw_recording(rng: Random) -> bytes:
    valid = _recording()
    start = rng.randrange(len(valid))
    return damaged_bytes(valid, valid[start:] + valid[:start], rng)


def _read_recording(drawn: bytes) -> bool:
    path = folder() / "damaged.mcap"
    path.write_bytes(drawn)
    try:
        found = read(path)
        _count(list(found.entries))
    except UsageError as error:
        raise RecordingError(str(error)) from error
    return True


def _count(found: Sequence[object]) -> None:
    assert len(found) < 1_000_000


KEPT = {
    "journal": Target(_draw_journal, _read_journal, JournalError, 1),
    "recording": Target(_draw_recording, _read_recording, RecordingError, 1),
}
