"""The journal as a file: what is noted is read again, and what is not as it was written is refused."""

from __future__ import annotations

import fcntl
import os
import struct
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.errors import JournalError
from protocol.messages import Command
from tests.world.driving import joined, two
from world.coordinator.inputs import Closed, Expected, Joined, Lost, Opened
from world.shell.persistence import journal as module
from world.shell.persistence import records
from world.shell.persistence.journal import Began, Entry, Journal, Seated
from world.shell.persistence.snapshot import Snapshot
from world.shell.processes import Processes

SCENARIO = two()
COMMAND = Command(1, 1, 0, (0.02, -0.1))
ENTRIES: list[Entry] = [
    Seated(1, "a"), Joined(1, 1), Seated(2, "b"), Joined(2, 1), Opened(), Began(12.5), COMMAND, Lost(2),
    Expected(2), Closed(77),
]  # fmt: skip


def opened(path: Path, run: str = "yard") -> Journal:
    return Journal(path, run, SCENARIO)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "journal"
    Journal.create(path, "yard", SCENARIO)
    return path


@pytest.fixture
def written(path: Path) -> Path:
    journal = opened(path)
    for entry in ENTRIES:
        journal.note(entry)
    journal.close()
    return path


def test_what_was_noted_is_read_again_and_added_to(written: Path) -> None:
    journal = opened(written)
    assert journal.past == ENTRIES
    journal.note(Joined(2, 2))
    journal.close()
    assert opened(written).past == [*ENTRIES, Joined(2, 2)]


def test_what_can_be_done_again_waits_for_what_follows(path: Path) -> None:
    journal = opened(path)
    before = path.stat().st_size
    for entry in (Opened(), COMMAND, Seated(1, "a")):
        journal.note(entry)
        assert path.stat().st_size == before
    journal.note(Closed(1))
    journal.close()
    assert opened(path).past == [Opened(), COMMAND, Seated(1, "a"), Closed(1)]


def test_to_try_again_to_open_a_tick_is_noted_once(path: Path) -> None:
    journal = opened(path)
    for _ in range(3):
        journal.note(Opened())
    journal.note(Lost(1))
    journal.note(Opened())
    journal.note(Lost(2))
    journal.close()
    assert opened(path).past == [Opened(), Lost(1), Opened(), Lost(2)]


@given(st.data())
@settings(max_examples=100, deadline=None)
def test_a_torn_last_record_is_cut_off(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    path = tmp_path_factory.mktemp("torn") / "journal"
    Journal.create(path, "yard", SCENARIO)
    journal = opened(path)
    ends = [path.stat().st_size]
    for entry in ENTRIES:
        journal.note(entry)
        ends.append(path.stat().st_size)
    journal.close()
    size = data.draw(st.integers(ends[0], ends[-1]))
    os.truncate(path, size)
    whole = [n for n in range(1, len(ends)) if ends[n - 1] < ends[n] <= size]
    journal = opened(path)
    assert journal.past == ENTRIES[: max(whole, default=0)]
    journal.note(Lost(9))
    journal.close()
    assert opened(path).past[-1] == Lost(9)


@given(st.data())
@settings(max_examples=200, deadline=None)
def test_one_damaged_byte_anywhere_is_refused_and_nothing_is_changed(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("damaged") / "journal"
    Journal.create(path, "yard", SCENARIO)
    journal = opened(path)
    for entry in ENTRIES:
        journal.note(entry)
    journal.close()
    content = bytearray(path.read_bytes())
    place = data.draw(st.integers(0, len(content) - 1))
    content[place] ^= data.draw(st.integers(1, 255))
    path.write_bytes(content)
    with pytest.raises(JournalError, match=str(path)):
        opened(path)
    assert path.read_bytes() == content


def test_a_record_that_is_whole_and_no_text_is_refused(written: Path) -> None:
    with written.open("ab") as file:
        file.write(records.record(b"\x91\x93\xa4seat\x01\xa1\xff"))
    with pytest.raises(JournalError, match="damaged at byte"):
        opened(written)


def test_damage_is_named_by_its_place(written: Path) -> None:
    content = bytearray(written.read_bytes())
    (size, _, _) = struct.unpack_from("<III", content, len(b"disknav journal 1\n"))
    place = len(b"disknav journal 1\n") + 12 + size
    content[place + 14] ^= 1
    written.write_bytes(content)
    with pytest.raises(JournalError, match=f"damaged at byte {place}"):
        opened(written)


def test_a_journal_of_something_else_is_refused_by_name(
    written: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(JournalError, match="of run 'yard', not of 'other'"):
        opened(written, "other")
    with pytest.raises(JournalError, match="of another scenario than"):
        Journal(written, "yard", replace(SCENARIO, seed=1))
    monkeypatch.setattr(module, "_boot", lambda: "another")
    with pytest.raises(JournalError, match="before this machine was last started"):
        opened(written)
    written.write_text("something else entirely")
    with pytest.raises(JournalError, match="no journal"):
        opened(written)
    written.unlink()
    with pytest.raises(JournalError, match="is not there"):
        opened(written)


def test_two_worlds_cannot_have_one_journal(written: Path) -> None:
    journal = opened(written)
    with pytest.raises(JournalError, match="in use"):
        opened(written)
    journal.close()
    opened(written).close()


def test_nor_one_that_the_other_begins_anew_meanwhile(written: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between opening a file and locking it, it can come to be another one's past."""
    journal, lock = opened(written), fcntl.flock

    def late(file: int, operation: int) -> None:
        monkeypatch.setattr(fcntl, "flock", lock)
        journal.compact(Snapshot(b"", b"", 0.0, Processes(), {}))
        lock(file, operation)

    monkeypatch.setattr(fcntl, "flock", late)
    with pytest.raises(JournalError, match="in use"):
        opened(written)
    journal.close()
    opened(written).close()


@pytest.mark.parametrize("step", ["write_bytes", "replace"])
def test_where_no_snapshot_can_be_written_the_journal_goes_on(
    written: Path, step: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a folder that is full, or not to be written to; or where the file itself is mounted."""

    def fail(*_: object) -> None:
        raise OSError(16, "Device or resource busy")

    said: list[str] = []
    journal = Journal(written, "yard", SCENARIO, said.append)
    before = journal.past
    with monkeypatch.context() as patch:
        patch.setattr(Path, step, fail)
        journal.compact(Snapshot(b"", b"", 0.0, Processes(), {}))
    journal.note(Lost(7))
    journal.close()
    assert len(said) == 1
    assert "busy" in said[0]
    assert opened(written).past == [*before, Lost(7)]
    assert list(written.parent.iterdir()) == [written]


def test_what_a_death_left_half_written_is_removed_with_it(written: Path) -> None:
    journal = opened(written)
    written.with_name(f"{written.name}.next").write_bytes(b"half")
    journal.remove()
    assert list(written.parent.iterdir()) == []


def test_what_is_there_is_not_overwritten(written: Path) -> None:
    with pytest.raises(JournalError, match="File exists"):
        Journal.create(written, "yard", SCENARIO)


@pytest.mark.parametrize("room", [0, 5])
def test_a_full_disk_is_said_once_and_leaves_no_old_checkpoint(
    path: Path, room: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(file: int, record: bytes) -> None:
        os.write(file, record[:room])
        raise OSError(28, "No space left on device")

    said: list[str] = []
    journal = Journal(path, "yard", SCENARIO, said.append)
    world = joined(two())
    world.coordinator.note = journal.note
    monkeypatch.setattr(records, "write", write)
    for _ in range(2):
        world.open_tick()
        world.close_tick()
    assert len(said) == 1
    assert "No space left on device" in said[0]
    assert not path.exists()
    journal.remove()


def test_where_it_can_be_neither_written_nor_removed_nothing_goes_on(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise OSError(5, "Input/output error")

    journal = opened(path)
    monkeypatch.setattr(records, "write", fail)
    monkeypatch.setattr(Path, "unlink", fail)
    with pytest.raises(JournalError, match="nor remove it"):
        journal.note(Lost(1))
