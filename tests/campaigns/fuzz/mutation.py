"""What a target of the fuzzer is, and damage to valid inputs: to bytes, to text, and to trees of values."""

import copy
import datetime
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random
from typing import Any, AnyStr

import msgspec

from protocol.errors import DisknavError


@dataclass(frozen=True)
class Target:
    """A reader.

    draw: an input; plain values whose `repr` gives them back.
    read: what it does with that.
    declared: the one kind of exception that may come of it.
    share: of all inputs, in parts of the sum of all shares; what takes long has a small one.
    """

    draw: Callable[[Random], Any]
    read: Callable[[Any], object]
    declared: type[DisknavError]
    share: int


_BYTES = tuple(map(bytes.fromhex, "00 01 7f 80 90 9f a0 c0 c1 c6 ca cb cf d9 dc dd df ff".split()))  # noqa: SIM905
_CHANGES = (1, 1, 1, 2, 4)
_CHARACTERS = "\0\t\n\r \"'#*$/.,:;=[]{}\\-_+0159eEaZzéß∞\u202e\ufeff\ud800😀"
_WORDS = """nan -inf true 1e999 0x_1 1979-05-27 [[]] ''' robots state/2 state/2 **""".split()  # noqa: SIM905
JUNK: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2**31, 2**53 + 1, 2**63 - 1, -(2**63), 2**64 - 1,
    0.0, -0.0, 1e-320, 5e-324, 1e308, -1e308, math.nan, math.inf, -math.inf, 0.1,
    "", "x", "auto", "state/2", "\0", "é" * 40, b"", b"\xff\xfe", [], {}, [[]], [{}], {"": 0},
    {"x": {}}, [0.0, 0.0], [1, "x"],
)  # fmt: skip
WRITTEN: tuple[Any, ...] = (
    *(value for value in JUNK if value is not None and not isinstance(value, bytes)),
    10**400, -(10**30), datetime.date(1979, 5, 27), datetime.time(7, 32),
    datetime.datetime(1979, 5, 27, 7, 32), "\ud800",
)  # fmt: skip
"""Junk that TOML, or a setting on a command line, can hold."""


def damaged_bytes(valid: bytes, other: bytes, rng: Random) -> bytes:
    """`valid` with a few changes; `other` is spliced in at times."""
    return _damaged(
        valid, other, rng, lambda: rng.choice((rng.choice(_BYTES), rng.randbytes(rng.randint(1, 8))))
    )


def damaged_text(valid: str, other: str, rng: Random) -> str:
    return _damaged(valid, other, rng, lambda: rng.choice((*_CHARACTERS, *_WORDS)))


def _damaged(valid: AnyStr, other: AnyStr, rng: Random, piece: Callable[[], AnyStr]) -> AnyStr:
    for _ in range(rng.choice(_CHANGES)):
        place, stop = sorted((rng.randint(0, len(valid)), rng.randint(0, len(valid))))
        match rng.randrange(6):
            case 0:
                valid = valid[:place] + piece() + valid[place + 1 :]
            case 1:
                valid = valid[:place] + piece() * rng.randint(1, 3) + valid[place:]
            case 2:
                valid = valid[:place] + valid[stop if rng.randrange(2) else place + 1 :]
            case 3:
                valid = valid[:stop] + valid[place:stop] + valid[stop:]
            case 4:
                valid = valid[:place] + other[place:stop] + valid[stop:]
            case _:
                valid = valid[:place]
    return valid


def damaged_tree(valid: Any, rng: Random, junk: tuple[Any, ...] = JUNK) -> Any:
    """A copy of a tree of lists and dictionaries with a few of its places changed."""
    holder = [copy.deepcopy(valid)]
    for _ in range(rng.choice(_CHANGES)):
        if places := list(_places(holder)):
            _change(*rng.choice(places), rng, junk)
    return holder[0] if holder else rng.choice(junk)


def deep(rng: Random, opening: Callable[[int], Any]) -> Any:
    """Something nested as deeply as a reader may not survive; `opening` gives it for a depth."""
    return opening(rng.choice((10, 100, 1_000, 10_000, 50_000)))


def _places(container: Any) -> Iterator[tuple[Any, Any]]:
    """Every place in a tree: its container, and its key or position in it."""
    for place, value in list(enumerate(container) if isinstance(container, list) else container.items()):
        yield container, place
        if isinstance(value, list | dict):
            yield from _places(value)


def _change(container: Any, place: Any, rng: Random, junk: tuple[Any, ...]) -> None:
    value = container[place]
    match rng.randrange(6):
        case 0:
            del container[place]
        case 1 if isinstance(container, list):
            container.insert(place, copy.deepcopy(value))
        case 1:
            container[rng.choice(("x", "", str(place) + "_", "robots", "delay"))] = copy.deepcopy(value)
        case 2 if isinstance(value, int | float) and abs(value) < 2**63:
            container[place] = rng.choice((-value, value * 1e6, value + 1, value / 3, float(value)))
        case 3 if isinstance(value, list | dict):
            container[place] = [copy.deepcopy(value)] * rng.randint(2, 3)
        case _:
            container[place] = copy.deepcopy(rng.choice(junk))


def damaged_message(valid: bytes, other: bytes, rng: Random) -> bytes:
    """A message in msgpack, valid or damaged in bytes or values; at times anything."""
    match rng.randrange(10):
        case 0:
            return valid
        case 1:
            return rng.randbytes(rng.randint(0, 64))
        case 2 if rng.randrange(50) == 0:
            opening = rng.choice((b"\x91", b"\x81\xa0", b"\xdd\xff\xff\xff\xff", b"\xdf\xff\xff\xff\xff\xa0"))
            return bytes(deep(rng, lambda depth: opening * depth))
        case 3 | 4 | 5 | 6:
            return damaged_bytes(valid, other, rng)
        case _:
            return msgspec.msgpack.encode(damaged_tree(msgspec.msgpack.decode(valid), rng))
