"""Compilation of the search's inner loops, by numba (extra `certify`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from protocol.process.installation import missing_library

try:
    from numba import njit
except ModuleNotFoundError as error:
    raise missing_library("a certificate", "numba", "certify") from error

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """The same function as machine code, kept on disk; strictly IEEE, nothing is reassociated or flushed."""
    return cast("F", njit(cache=True, error_model="numpy", fastmath=False)(function))
