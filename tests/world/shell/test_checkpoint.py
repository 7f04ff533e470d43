"""The checkpoint as a file: what was written last is read; what is not whole or of another run is refused."""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock, patch

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.errors import CheckpointError
from protocol.messages import Standing
from tests.world.driving import advance, joined, two
from world.shell import checkpoint as module
from world.shell.checkpoint import Checkpoint, Processes, SavedRun
from world.world import WorldCore

SCENARIO = two()


@pytest.fixture(autouse=True, scope="module")
def _small_files() -> object:
    with patch.object(module, "_STATE", 1 << 13):
        yield


def states(count: int) -> list[SavedRun]:
    world, found = joined(SCENARIO), []
    for tick in range(count):
        advance(world, {1: (0.02, 0.0)})
        processes = Processes({1: "a", 2: "b"}, {1: {"c": "ended"}}, {2: 1})
        found.append(SavedRun((7, 8), 12.5 + tick, processes, world.past))
    return found


STATES = states(3)


def opened(path: Path, run: str = "yard") -> Checkpoint:
    return Checkpoint(path, run, SCENARIO)


def write(path: Path, *states: SavedRun) -> None:
    checkpoint = opened(path)
    for state in states:
        checkpoint.write(state)
    checkpoint.close()


def left(path: Path) -> SavedRun:
    found = opened(path)
    found.close()
    return found.progress


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "checkpoint"
    Checkpoint.create(path)
    return path


@pytest.fixture
def written(path: Path) -> Path:
    write(path, *STATES)
    return path


def test_what_was_written_last_is_read_again(path: Path) -> None:
    assert left(path) == SavedRun()
    for state in STATES:
        write(path, state)
        found = left(path)
        assert (found.past.tick, found) == (state.past.tick, msgspec.structs.replace(state, past=found.past))
        assert WorldCore(SCENARIO, found.past).truth == WorldCore(SCENARIO, state.past).truth


def torn(before: bytes, after: bytes, data: st.DataObject) -> bytes:
    differ = [place for place, (old, new) in enumerate(zip(before, after, strict=False)) if old != new]
    cut = data.draw(st.integers(differ[0], differ[-1]))
    return after[:cut] + before[cut:]


def damaged(_: bytes, after: bytes, data: st.DataObject) -> bytes:
    place = data.draw(st.sampled_from([at for at, byte in enumerate(after) if byte][len(module._MAGIC) :]))
    return after[:place] + bytes([after[place] ^ data.draw(st.integers(1, 255))]) + after[place + 1 :]


@pytest.mark.parametrize(("damage", "left_over"), [(torn, {2}), (damaged, {2, 3})])
@given(st.data())
@settings(max_examples=60, deadline=None)
def test_of_a_write_that_was_cut_short_or_damaged_the_state_before_is_left(
    damage: Callable[[bytes, bytes, st.DataObject], bytes],
    left_over: set[int],
    tmp_path_factory: pytest.TempPathFactory,
    data: st.DataObject,
) -> None:
    path = tmp_path_factory.mktemp("torn") / "checkpoint"
    Checkpoint.create(path)
    contents = []
    for state in STATES:
        write(path, state)
        contents.append(path.read_bytes())
    path.write_bytes(damage(*contents[-2:], data))
    assert left(path).past.tick in left_over


def test_a_first_state_that_was_cut_short_has_told_nothing(path: Path) -> None:
    write(path, STATES[0])
    content = path.read_bytes()
    half, end = content.index(b"worlds"), module._place(1)
    path.write_bytes(content[:half] + bytes(end - half) + content[end:])
    assert left(path) == SavedRun()


def test_a_file_without_a_whole_state_is_refused(path: Path) -> None:
    content = path.read_bytes()
    path.write_bytes(module._MAGIC + bytes(len(content) - len(module._MAGIC)))
    with pytest.raises(CheckpointError, match="neither of its two states is whole"):
        opened(path)


@given(st.data())
def test_of_a_file_that_was_cut_short_nothing_is_half_read(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("short") / "checkpoint"
    Checkpoint.create(path)
    write(path, STATES[0])
    size = path.stat().st_size
    os.truncate(path, size - data.draw(st.one_of(st.integers(1, 2000), st.integers(1, size))))
    content = path.read_bytes()
    with pytest.raises(CheckpointError, match=str(path)):
        opened(path)
    assert path.read_bytes() == content


def test_a_checkpoint_of_something_else_is_refused_by_name(written: Path) -> None:
    with pytest.raises(CheckpointError, match="of run 'yard', not of 'other'"):
        opened(written, "other")
    with pytest.raises(CheckpointError, match="of another scenario than"):
        Checkpoint(written, "yard", replace(SCENARIO, seed=1))
    booted = patch.object(module, "boot", return_value="another")
    with booted, pytest.raises(CheckpointError, match="from before this machine was last started"):
        opened(written)
    decodes = patch.object(module, "_decoder", msgspec.msgpack.Decoder(Standing))
    with decodes, pytest.raises(CheckpointError, match="of another version of disknav"):
        opened(written)
    written.write_text("something else entirely")
    with pytest.raises(CheckpointError, match="or no checkpoint; name another file"):
        opened(written)
    written.unlink()
    with pytest.raises(CheckpointError, match="does not exist"):
        opened(written)


def test_two_worlds_cannot_have_one_checkpoint(written: Path) -> None:
    checkpoint = opened(written)
    with pytest.raises(CheckpointError, match="in use"):
        opened(written)
    checkpoint.close()
    opened(written).close()


@pytest.mark.parametrize("again", [True, False])
def test_a_file_that_another_world_replaced_meanwhile_is_not_taken(again: bool, path: Path) -> None:
    def locked(*_: object) -> None:
        path.unlink()
        if again:
            Checkpoint.create(path)

    locks = patch.object(module.fcntl, "flock", locked)
    with locks, pytest.raises(CheckpointError, match="in use by another world"):
        opened(path)


def test_what_is_no_file_is_refused(path: Path) -> None:
    locks = patch.object(module.fcntl, "flock", side_effect=OSError(37, "No locks available"))
    with locks, pytest.raises(CheckpointError, match="No locks available"):
        opened(path)
    elsewhere = path.rename(path.with_name("elsewhere"))
    path.symlink_to(elsewhere)  # the file would outlast its removal
    with pytest.raises(CheckpointError, match="symbolic links"):
        opened(path)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(CheckpointError, match="not a regular file"):
        opened(path)


def test_a_file_that_cannot_be_made_whole_leaves_none(tmp_path: Path) -> None:
    full = patch.object(module, "_frame", side_effect=OSError(28, "No space left on device"))
    with full, pytest.raises(CheckpointError, match="No space left"):
        Checkpoint.create(tmp_path / "made")
    assert list(tmp_path.iterdir()) == []


def test_another_world_finds_a_new_file_whole_or_not_at_all(tmp_path: Path) -> None:
    path, link = tmp_path / "made", os.link

    def linked(*names: Path) -> None:
        assert not path.exists()
        link(*names)
        assert left(path) == SavedRun()

    with patch.object(os, "link", side_effect=linked) as made:
        Checkpoint.create(path)
    assert (made.called, list(tmp_path.iterdir())) == (True, [path])


def test_what_is_there_is_not_overwritten(written: Path) -> None:
    with pytest.raises(CheckpointError, match="File exists"):
        Checkpoint.create(written)
    assert left(written).past.tick == STATES[-1].past.tick


@pytest.mark.parametrize("linked", [False, True])
def test_in_place_of_its_file_another_is_left_alone(path: Path, linked: bool) -> None:
    said: list[str] = []
    checkpoint = Checkpoint(path, "yard", SCENARIO, said.append)
    if linked:
        os.link(path, path.with_name("backup"))
    path.unlink()
    Checkpoint.create(path)
    for state in STATES:
        checkpoint.write(state)
    assert (["it was deleted" in text for text in said], checkpoint.kept) == ([True] * (not linked), linked)
    checkpoint.remove()
    assert left(path) == SavedRun()


@pytest.mark.parametrize("room", [0, 5, OSError(28, "No space left on device")])
def test_a_full_disk_is_said_once_and_leaves_nothing_to_go_on_from(path: Path, room: int | OSError) -> None:
    said: list[str] = []
    checkpoint, elsewhere = Checkpoint(path, "yard", SCENARIO, said.append), path.with_name("elsewhere")
    checkpoint.write(STATES[0])
    path.rename(elsewhere)
    with patch.object(os, "pwrite", side_effect=[room]):
        checkpoint.write(STATES[1])
    checkpoint.write(STATES[2])
    assert (["full" in text or "No space" in text for text in said], checkpoint.kept) == ([True], False)
    elsewhere.rename(path)
    checkpoint.close()
    with pytest.raises(CheckpointError, match="is empty: a world could not write it"):
        opened(path)
    checkpoint.remove()
    assert not path.exists()


def test_where_it_can_be_neither_written_nor_emptied_nothing_goes_on(path: Path) -> None:
    checkpoint, fail = opened(path), Mock(side_effect=OSError(5, "Input/output error"))
    fails = patch.multiple(os, pwrite=fail, ftruncate=fail)
    with fails, pytest.raises(CheckpointError, match=r"neither written \(Input.*\) nor emptied: Input"):
        checkpoint.write(STATES[0])
