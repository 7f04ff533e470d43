"""One channel of a recording: what is said under one key, checked and ready to become JSON."""

from __future__ import annotations

from typing import Any

import msgspec

from deploy.recording.form import to_object
from protocol.codec import decode_numbers
from protocol.keys import Address
from protocol.streams import STREAMS


class Channel:
    """What is written under one key.

    Attributes:
        number: of the channel in the file.
        form: turns a message into what JSON writes.
    """

    def __init__(self, address: Address, number: int) -> None:
        stream = STREAMS[address.stream]
        self.stream, self.robot, self.number = address.stream, address.robot, number
        self.form = to_object(stream.message)
        self._decode = msgspec.msgpack.Decoder(stream.message).decode
        self._limit = stream.limit
        self._speaker = "robot" in stream.message.__struct_fields__

    def read(self, payload: bytes) -> Any:
        """The message that `payload` is; its numbers may be infinite, or none.

        Raises:
            MessageError: it is none, or another robot's.
        """
        if len(payload) <= self._limit:
            try:
                message: Any = self._decode(payload)
            except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
                pass
            else:
                if not self._speaker or message.robot == self.robot:
                    return message
        return decode_numbers(self.stream, self.robot, payload)  # which says what is wrong
