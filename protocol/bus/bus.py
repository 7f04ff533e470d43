"""What a process may ask of a network. Two implementations: `zenoh` and `local`.

A bus turns everything that happens into events, taken one at a time by `receive`; nothing runs
behind the caller's back. A `Node` is whatever handles these events: it can be driven by its own
process (`serve`) or, in one process with others, by the in-process network.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple, Protocol, final

from mypy_extensions import mypyc_attr

from protocol.streams import Stream

Publish = Callable[[bytes], None]


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
    """A request under `key`; exactly one `reply` is expected."""

    __slots__ = ("key", "payload", "reply")

    def __init__(self, key: str, payload: bytes, reply: Callable[[bytes], None]) -> None:
        self.key, self.payload, self.reply = key, payload, reply


Event = Sample | Presence | Request


class Bus(Protocol):
    """One participant's connection. Not thread-safe: one thread owns it."""

    def publisher(self, stream: Stream, key: str) -> Publish:
        """Declare a publication; the returned function publishes one payload. No bus hears itself."""

    def foreign(self, key: str) -> Publish:
        """The same for a key outside this fleet; what cannot be sent at once is dropped."""

    def is_heard(self, key: str) -> bool:
        """Whether `key` may have a subscriber; True where that is not known."""

    def subscribe(self, *key_expressions: str) -> None:
        """Ask for samples under key expressions; under plain keys they cost least."""

    def unsubscribe(self, key: str) -> None:
        """Ask for no more samples under a plain key."""

    def expect(self, keys: Iterable[str]) -> None:
        """Say which keys will be heard by way of a pattern; under those a sample costs less to hear."""

    def watch(self, key_expression: str) -> None:
        """Ask for presence of liveliness tokens, those already there included."""

    def serve(self, key: str) -> None:
        """Answer the requests under `key`."""

    def announce(self, key: str) -> None:
        """Declare a liveliness token: it lasts until `close`, or until this process dies."""

    def ask(self, key: str, payload: bytes, timeout: float) -> list[bytes]:
        """Request, and wait for the replies of all that serve `key`; raises BusError after `timeout` seconds
        without one."""

    def tokens(self, key_expression: str) -> list[str]:
        """Keys of the liveliness tokens that are there now, those of this participant included."""

    def receive(self, timeout: float) -> Event | None:
        """The next event, or None after `timeout` seconds (0: only what is there already)."""

    def close(self) -> None:
        """Withdraw everything and disconnect; may be called twice."""


class Node(Protocol):
    """A participant, driven by events."""

    def handle(self, event: Event) -> None:
        """React to one event."""

    def wake(self, now: float) -> None:
        """React to the passing of time: `now` (s, monotonic) reached `deadline`."""

    @property
    def deadline(self) -> float:
        """When `wake` wants to be called next, s, monotonic; infinity for never."""

    @property
    def finished(self) -> bool:
        """True when the node has nothing more to do."""
