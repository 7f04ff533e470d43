"""One chunk of an MCAP file while it fills: columns, of which the records are made when it is closed.

For a whole chunk an operation on arrays takes as long as a handful of messages one by one.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import BinaryIO, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

Times = NDArray[np.uint64]

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


class Contents(NamedTuple):
    """What is in a chunk.

    Attributes:
        indexes: message index records, by channel.
        start, end: smallest and largest log time, ns; 0 if there are no messages.
    """

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
        self._times: list[Times] = [np.empty(0, np.uint64)]
        self._data: list[bytes] = []

    def declare(self, record: bytes) -> None:
        """Add the record of a schema or channel."""
        self._declared += record
        self.size += len(record)

    def add(self, channels: Sequence[int], times: Times, lines: bytes) -> None:
        """Add messages: their channels' numbers, when they were published and logged, ns, and their JSON,
        each with a line break after it."""
        self._channels += channels
        self._times.append(times)
        self._data += lines.split(b"\n")[:-1]
        self.size += len(lines) + (_HEAD.itemsize - 1) * len(channels)

    def put(self, channel: int, time: int, data: bytes) -> None:
        """Add one message of any encoding."""
        self._channels.append(channel)
        self._times.append(np.array([time], np.uint64))
        self._data.append(data)
        self.size += _HEAD.itemsize + len(data)

    def write(self, file: BinaryIO, counts: NDArray[np.int64]) -> Contents:
        """Write all records; `counts`, the messages of each channel so far, goes on counting."""
        heads = self._heads()
        order = np.argsort(heads["channel"], kind="stable")  # those of one channel side by side
        numbers, starts, added = np.unique(heads["channel"][order], return_index=True, return_counts=True)
        heads["sequence"][order] = np.arange(len(order)) + np.repeat(counts[numbers] - starts, added)
        counts[numbers] += added
        entries = self._entries(heads)[order].tobytes()
        ends = np.cumsum(added) * _ENTRY.itemsize
        begins = ends - added * _ENTRY.itemsize
        indexes = {
            channel: _index(channel, entries[begin:end])
            for channel, begin, end in zip(numbers.tolist(), begins.tolist(), ends.tolist(), strict=True)
        }
        times = heads["log_time"] if len(heads) else np.zeros(1)
        file.write(self._declared)
        file.writelines(self._parts(heads))
        return Contents(indexes, int(times.min()), int(times.max()))

    def _heads(self) -> np.ndarray:
        """What stands before the data of each message, but for the sequence number."""
        heads = np.empty(len(self._data), _HEAD)
        heads["opcode"] = Opcode.MESSAGE
        heads["length"] = np.fromiter(map(len, self._data), np.uint64, len(self._data))
        heads["length"] += _HEAD.itemsize - _UNCOUNTED
        heads["channel"] = self._channels
        heads["log_time"] = heads["publish_time"] = np.concatenate(self._times)
        return heads

    def _entries(self, heads: np.ndarray) -> np.ndarray:
        """When each message was logged and where it begins."""
        sizes = heads["length"] + _UNCOUNTED
        entries = np.empty(len(heads), _ENTRY)
        entries["time"] = heads["log_time"]
        entries["offset"] = len(self._declared) + np.cumsum(sizes) - sizes
        return entries

    def _parts(self, heads: np.ndarray) -> list[bytes]:
        parts = [b""] * (2 * len(heads))
        parts[::2] = heads.view(f"V{_HEAD.itemsize}").tolist()
        parts[1::2] = self._data
        return parts


def _index(channel: int, entries: bytes) -> bytes:
    size = len(entries)
    return _INDEX.pack(Opcode.MESSAGE_INDEX, _INDEX.size - _UNCOUNTED + size, channel, size) + entries
