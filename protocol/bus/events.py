"""What can happen to a participant of a network."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, final

from mypy_extensions import mypyc_attr


@final
@mypyc_attr(acyclic=True)
class Sample:
    """Something was published under `key`. Immutable."""

    __slots__ = ("key", "payload")

    def __init__(self, key: str, payload: bytes) -> None:
        self.key, self.payload = key, payload

    def __repr__(self) -> str:
        return f"Sample({self.key!r}, {self.payload!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sample) and self.key == other.key and self.payload == other.payload

    def __hash__(self) -> int:
        return hash((self.key, self.payload))


class Presence(NamedTuple):
    """A liveliness token appeared or went."""

    key: str
    alive: bool


@final
class Request:
    """Somebody asks under `key`; exactly one `reply` is expected."""

    __slots__ = ("key", "payload", "reply")

    def __init__(self, key: str, payload: bytes, reply: Callable[[bytes], None]) -> None:
        self.key, self.payload, self.reply = key, payload, reply


Event = Sample | Presence | Request
