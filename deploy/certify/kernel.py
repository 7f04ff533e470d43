"""Compilation of the certificate's inner loops, by numba (extra `certify`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """The same function as machine code, strictly IEEE: nothing is reassociated, contracted or flushed."""
    return cast("F", njit(cache=True, error_model="numpy", fastmath=False)(function))
