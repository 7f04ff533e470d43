"""What a robot needs of whatever moves it, if it is not simulated."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from protocol.messages import Command, Sense, Tick, Vector


class Base(Protocol):
    """A base and a localisation outside. Sans-I/O: it is told what arrives, and says what is to be sent.

    Attributes:
        keys: under which it wants to hear.
        tells: the key under which it sends.
        due: when `wake` wants to be called, s.
    """

    keys: tuple[str, ...]
    tells: str
    due: float

    @property
    def note(self) -> str:
        """Why nothing can be relied on, so that the robot stands; "" if all is well."""
        ...

    def hear(self, key: str, payload: bytes, now: float) -> None:
        """Something arrived under one of `keys`."""

    def place(self) -> tuple[Vector, float] | None:
        """Where the robot is, m, and by how much that may be off, m; None if that is not known."""
        ...

    def begin(self, tick: Tick, now: float) -> Sense | None:
        """A tick begins: what is known of the robot; None if nothing can be relied on."""
        ...

    def begins_anew(self) -> bool:
        """Whether all is well after it was not, so that what was known before is void; says so once."""
        ...

    def obey(self, command: Command, now: float) -> None:
        """Carry out the Command of the tick that began last; to be called before it is sent."""

    def doubt(self, why: str) -> None:
        """The robot found out that what it was told cannot be true: rely on nothing so far."""

    def stand(self, now: float) -> None:
        """Brake: no tick goes on."""

    def wake(self, now: float) -> Iterable[bytes]:
        """What is to be sent under `tells` by now."""
        ...
