"""What a target of the fuzzer is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from random import Random
from typing import Any

from protocol.errors import DisknavError


@dataclass(frozen=True)
class Target:
    """A reader.

    draw: an input; plain values whose `repr` gives them back.
    read: what it does with that; whether it was accepted.
    declared: the one kind of exception that may come of it.
    share: of all inputs, in parts of the sum of all shares; what takes long has a small one.
    """

    draw: Callable[[Random], Any]
    read: Callable[[Any], bool]
    declared: type[DisknavError]
    share: int
