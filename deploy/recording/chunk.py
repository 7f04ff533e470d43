"""One chunk of an MCAP file while it fills: columns, of which the records are made when it is closed.

For a whole chunk an operation on arrays takes as long as a handful of messages one by one.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

Integers = NDArray[np.integer]

_HEAD = np.dtype(
    [
        ("opcode", "<u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)  # a message without its data
_UNCOUNTED = 9  # bytes of opcode and length, which the length leaves out
_INDEX = struct.Struct("<BQHI")  # opcode, length, channel, bytes of the entries
_ENTRY = np.dtype([("time", "<u8"), ("offset", "<u8")])


class Packed(NamedTuple):
    """A chunk as it goes to the file.

    Attributes:
        records: the declarations and messages, uncompressed.
        indexes: message index records, by channel.
        start, end: smallest and largest log time, ns; 0 if there are no messages.
    """

    records: bytes
    indexes: dict[int, bytes]
    start: int
    end: int


class Chunk:
    """Declarations, and after them the messages in the order in which they were added.

    Attributes:
        size: bytes of all records.
    """

    def __init__(self) -> None:
        self.size = 0
        self._declared = b""
        self._channels: list[int] = []
        self._times: list[int] = []
        self._data: list[bytes] = []

    def declare(self, record: bytes) -> None:
        """Add the record of a schema or channel."""
        self._declared += record
        self.size += len(record)

    def add(self, channels: Sequence[int], times: Sequence[int], data: Sequence[bytes]) -> None:
        """Add messages: the number of each one's channel, its time, ns, and its content."""
        self._channels += channels
        self._times += times
        self._data += data
        self.size += sum(map(len, data)) + _HEAD.itemsize * len(data)

    def packed(self, counts: Integers) -> Packed:
        """All records; `counts`, the messages said so far by channel, goes on counting."""
        heads = self._heads()
        order = np.argsort(heads["channel"], kind="stable")  # those of one channel side by side
        numbers, starts = np.unique(heads["channel"][order], return_index=True)
        ends = np.append(starts[1:], len(order))
        heads["sequence"][order] = np.arange(len(order)) + np.repeat(counts[numbers] - starts, ends - starts)
        counts[numbers] += ends - starts
        entries = self._entries(heads)[order].tobytes()
        indexes = {
            channel: _index(channel, entries[start * _ENTRY.itemsize : end * _ENTRY.itemsize])
            for channel, start, end in zip(numbers.tolist(), starts.tolist(), ends.tolist(), strict=True)
        }
        times = self._times or [0]
        return Packed(self._joined(heads), indexes, min(times), max(times))

    def _heads(self) -> np.ndarray:
        """What stands before the data of each message, but for the sequence number."""
        heads = np.empty(len(self._data), _HEAD)
        heads["opcode"] = Opcode.MESSAGE
        heads["length"] = np.fromiter(map(len, self._data), np.uint64, len(self._data))
        heads["length"] += _HEAD.itemsize - _UNCOUNTED
        heads["channel"] = self._channels
        heads["log_time"] = heads["publish_time"] = np.array(self._times, np.uint64)
        return heads

    def _entries(self, heads: np.ndarray) -> np.ndarray:
        """When each message was logged and where it begins."""
        sizes = heads["length"] + _UNCOUNTED
        entries = np.empty(len(heads), _ENTRY)
        entries["time"] = heads["log_time"]
        entries["offset"] = len(self._declared) + np.cumsum(sizes) - sizes
        return entries

    def _joined(self, heads: np.ndarray) -> bytes:
        parts = [b""] * (2 * len(heads))
        parts[::2] = heads.view(f"V{_HEAD.itemsize}").tolist()
        parts[1::2] = self._data
        return self._declared + b"".join(parts)


def _index(channel: int, entries: bytes) -> bytes:
    return (
        _INDEX.pack(Opcode.MESSAGE_INDEX, _INDEX.size - _UNCOUNTED + len(entries), channel, len(entries))
        + entries
    )
