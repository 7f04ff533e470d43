"""Steering a lock-step run from outside: a request under `world/steering`, which the world answers.

`{"pause": true}` holds the clock, `{"pause": false}` lets it go on, `{"step": n}` holds it after n
more ticks, `{"speed": x}` limits simulated seconds per second (0: as fast as the machine allows). Maps in
msgpack, or JSON text; the reply, in msgpack, is what is in force: `paused`, `steps` still allowed, and
`speed`. It changes when ticks happen, never what happens in them; in real time nothing.
"""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta

from protocol.messages import Size
from protocol.requests.form import read_request

LIMIT = 1024  # bytes of a request


class Steer(msgspec.Struct, frozen=True):
    """What is asked; None leaves a setting as it is."""

    pause: bool | None = None
    step: Annotated[int, Meta(ge=0, le=1_000_000)] | None = None
    speed: Size | None = None


class Steering(msgspec.Struct):
    """What is in force."""

    paused: bool = False
    steps: int = 0
    speed: float = 0.0

    def apply(self, steer: Steer) -> None:
        """Take over what is asked."""
        if steer.pause is not None:
            self.paused, self.steps = steer.pause, 0
        if steer.step is not None:
            self.paused, self.steps = True, self.steps + steer.step
        if steer.speed is not None:
            self.speed = steer.speed

    def allow(self) -> bool:
        """Whether a tick may begin now; uses up one step while paused."""
        if not self.paused:
            return True
        if self.steps == 0:
            return False
        self.steps -= 1
        return True


def decode_steer(payload: bytes) -> Steer:
    """Read a request; raises MessageError."""
    return read_request(payload, Steer, "steering", LIMIT)
