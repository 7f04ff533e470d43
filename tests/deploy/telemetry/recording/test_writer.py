"""Recording files: what is written and refused, files that continue each other, a disk that is full."""

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from deploy.telemetry.recording.reader import read
from deploy.telemetry.recording.replay import recomputed, verify
from deploy.telemetry.recording.writer import RecordingFile, RecordingWriter, Rotation, rotation
from protocol.codec import encode
from protocol.errors import RecordingError, UsageError
from protocol.keys import robot_key, world_key
from protocol.messages import Clock, Command, Health, Truth
from tests.deploy.telemetry.recording.recorded import ROBOTS, said_by, scenario


def said(tick: int) -> list[tuple[str, bytes]]:
    """What is said in one tick, much of it: no compression makes it small."""
    robots, positions = tuple(r.id for r in ROBOTS), tuple(r.start for r in ROBOTS)
    reason = os.urandom(1000).hex()
    return [
        (world_key("r", "truth"), encode(Truth(tick, robots, positions, 0.1, 0.5))),
        *[(world_key("r", "clock"), encode(Clock(tick, 0.05 * tick, (), (), "", reason=reason)))],
    ]


def write(file: RecordingWriter, ticks: range) -> None:
    for tick in ticks:
        file.write(said(tick))
        file.flush()


def test_the_good_messages_of_a_batch_are_kept_in_order(tmp_path: Path) -> None:
    file = RecordingFile(tmp_path / "x.mcap", "r", scenario())
    key = robot_key("r", 1, "command")
    good = [Command(1, 1, tick, (0.1, float(tick))) for tick in range(2000)]
    bad = encode(Command(1, 1, 0, (0.1, float("inf")))), encode(Command(2, 1, 0, (0.1, 0.2))), b"\x93"
    batch = []
    for command in good:
        batch.append((key, encode(command)))
        batch.append((key, bad[command.tick % 3]))
    note = encode(Health(1, 1, 3, 0.0, 1, 1, {}, (), (), "null"))
    batch.append((robot_key("r", 1, "health"), note))  # a word, and no number
    file.write(batch)
    file.finish()
    found = read(tmp_path / "x.mcap")
    assert said_by(found, Command, 1) == good
    assert [each.note for each in said_by(found, Health, 1)] == ["null"]
    assert file.rejected == {"shape": 1333, "identity": 667}


def test_a_file_that_cannot_be_created_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"cannot record to .*x\.mcap"):
        RecordingWriter(tmp_path / "no" / "x.mcap", "r", scenario())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("given", "meant"),
    [([], Rotation()), (["500MB"], Rotation(5e8)), (["2d", "90min", "1.5h", "1kB"], Rotation(1e3, 5400.0))],
)
def test_what_a_person_writes(given: list[str], meant: Rotation) -> None:
    assert rotation(given) == meant


@pytest.mark.parametrize("text", ["", "5", "MB", "-1h", "0s", "1 h", "1e3s", "5m"])
def test_what_says_neither_size_nor_age(text: str) -> None:
    with pytest.raises(UsageError, match=r"give a number and a unit \(kB, MB, GB, s, min, h, d\)"):
        rotation([text])


def test_a_recording_goes_on_in_another_file_and_is_read_as_one(tmp_path: Path) -> None:
    path, named = tmp_path / "r.mcap", list[str]()
    (tmp_path / "r-3.mcap").write_text("another program's")
    file = RecordingWriter(path, "r", scenario(), Rotation(size=80_000), named.append)
    write(file, range(1, 201))
    file.finish('{"verdict": "arrived"}')
    assert named[:3] == [str(path), str(tmp_path / "r-2.mcap"), str(tmp_path / "r-4.mcap")]
    assert all(80_000 <= Path(each).stat().st_size < 120_000 for each in named[:-1])
    whole = read(path)
    assert (whole.cut, whole.result) == (False, {"verdict": "arrived"})
    assert whole.trajectory.ticks.tolist() == list(range(201))
    assert [clock.tick for clock in whole.messages(Clock)] == list(range(1, 201))
    assert whole.counts == {world_key("r", "truth"): 200, world_key("r", "clock"): 200}
    assert all(one.time <= other.time for one, other in pairwise(whole.entries))
    later = read(Path(named[1]))
    assert not later.cut
    assert 1 < later.trajectory.ticks[0] < later.trajectory.ticks[-1] == 200
    assert later.preceding == "r.mcap"
    assert verify(later) is None
    with pytest.raises(RecordingError, match=r"continues r\.mcap: name the first file of the recording"):
        recomputed(later)
    with pytest.raises(RecordingError, match="Truth of tick 0, the first of the trajectory, was not"):
        recomputed(replace(later, preceding=""))
    Path(named[-1]).unlink()
    lacking = read(path)
    assert (lacking.cut, lacking.result) == (True, None)
    assert len(lacking.trajectory.ticks) > 150
    Path(named[-1]).write_bytes(path.read_bytes())  # leads in a circle, or to another run
    assert read(path).trajectory.ticks[-1] == lacking.trajectory.ticks[-1]


def test_one_that_is_old_enough_is_followed_by_another(tmp_path: Path) -> None:
    file = RecordingWriter(tmp_path / "r.mcap", "r", scenario(), Rotation(age=1e-9))
    write(file, range(1, 4))
    file.finish()
    assert {each.stem for each in tmp_path.iterdir()} == {"r", "r-2", "r-3", "r-4"}
    assert read(tmp_path / "r.mcap").trajectory.ticks.tolist() == [0, 1, 2, 3]


# -- a disk that is full


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    folder = tmp_path / "small"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=2m", "disknav-test", str(folder)]
    if os.geteuid() or subprocess.run(mount, check=False, capture_output=True).returncode:
        pytest.skip("no file system can be mounted here (root on Linux can): untested")
    yield folder
    subprocess.run(["umount", "-l", str(folder)], check=True)


@pytest.mark.process
@pytest.mark.timeout(60)
@pytest.mark.long(10)
def test_a_run_goes_on_when_the_disk_is_full(small_disk: Path) -> None:
    (small_disk / "other").write_bytes(bytes(1_970_000))
    path = small_disk / "run.mcap"
    call = [sys.executable, "-m", "disknav", "run", "figure-3d", "--record", str(path)]
    done = subprocess.run(call, capture_output=True, text=True, timeout=50, check=False)
    assert done.returncode == 0, done.stderr
    assert "No space left on device" in done.stderr
    found = read(path)
    assert found.cut
    assert found.trajectory.ticks[-1] > 1
    assert recomputed(found).restored == 0
