"""One channel of a recording: what is said under one key, checked and ready to become JSON."""

from __future__ import annotations

from deploy.recording.form import to_object
from protocol.keys import Address
from protocol.streams import STREAMS
from protocol.wire.reader import Reader


class Channel:
    """What is written under one key.

    Attributes:
        number: of the channel in the file.
        read: makes a message of a payload, see `Reader`.
        form: turns a message into what JSON writes.
    """

    def __init__(self, address: Address, number: int) -> None:
        self.stream, self.number = address.stream, number
        self.read = Reader(address.stream, address.robot).read
        self.form = to_object(STREAMS[address.stream].message)
