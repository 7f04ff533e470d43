"""What a fleet keeps on disk, damaged or made up: the world's checkpoint, and recordings.

A checkpoint says when, and since which start of the machine: what is drawn from it differs each time.
"""

from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from unittest.mock import patch

import msgspec

from deploy.telemetry.recording.reader import read
from protocol.errors import CheckpointError, RecordingError, UsageError
from protocol.scenario.model import Time
from tests.campaigns.fuzz.mutation import Target, damaged_bytes, damaged_tree
from tests.deploy.telemetry.recording.recorded import record
from tests.mortal import MortalFleet
from tests.world.driving import two
from world.shell import checkpoint
from world.shell.checkpoint import _FRAME, Checkpoint, _frame, _place, _whole

_SCENARIO = two()
_TICKS = 12
_STATE = 1 << 16  # bytes between its two states


@cache
def _temporary() -> TemporaryDirectory[str]:
    memory = "/dev/shm"
    return TemporaryDirectory(prefix="disknav-fuzz-", dir=memory if Path(memory).is_dir() else None)


def folder() -> Path:
    """A scratch folder that goes with this process."""
    return Path(_temporary().name)


def written(name: str, content: bytes) -> Path:
    """A file in it."""
    path = folder() / name
    path.write_bytes(content)
    return path


@cache
def _checkpoint() -> bytes:
    """That of a run in its first ticks."""
    path = folder() / "valid"
    with patch.object(checkpoint, "_STATE", _STATE):
        fleet = MortalFleet(_SCENARIO, path)
        fleet.network.run(lambda: fleet.world.world.tick >= _TICKS)
        fleet.kill_world()
    return path.read_bytes()


def _draw_checkpoint(rng: Random) -> bytes:
    """Damage to the bytes, or a newest state that is whole and says something else."""
    valid = _checkpoint()
    if rng.randrange(8) == 0:
        return valid
    if rng.randrange(4) == 0:
        return damaged_bytes(valid, valid[::-1], rng)
    with patch.object(checkpoint, "_STATE", _STATE):
        number, payload = max(filter(None, (_whole(valid[_place(index) :]) for index in (0, 1))))
        if rng.randrange(2):
            changed = damaged_bytes(payload, valid, rng)
        else:
            changed = msgspec.msgpack.encode(damaged_tree(msgspec.msgpack.decode(payload), rng))
        place = _place((number + 1) % 2)
    framed = bytearray(_FRAME.size) + changed
    _frame(number + 1, framed)
    return valid[:place] + framed + valid[place + len(framed) :]


def _read_checkpoint(drawn: bytes) -> None:
    with patch.object(checkpoint, "_STATE", _STATE):
        Checkpoint(written("checkpoint", drawn), "local", _SCENARIO).remove()


@cache
def _recording() -> bytes:
    path = folder() / "valid.mcap"
    record(path, time=Time(limit=0.2))
    return path.read_bytes()


def _draw_recording(rng: Random) -> bytes:
    valid = _recording()
    start = rng.randrange(len(valid))
    return damaged_bytes(valid, valid[start:] + valid[:start], rng)


def _read_recording(drawn: bytes) -> None:
    try:
        list(read(written("damaged.mcap", drawn)).entries)
    except UsageError as error:
        raise RecordingError(str(error)) from error


KEPT = {
    "checkpoint": Target(_draw_checkpoint, _read_checkpoint, CheckpointError, 1),
    "recording": Target(_draw_recording, _read_recording, RecordingError, 1),
}
