"""Processes beside this one that nobody waits for without bound, at its end either."""

from __future__ import annotations

from collections.abc import Callable
from multiprocessing.context import ForkProcess
from multiprocessing.process import BaseProcess
from typing import Any

_DEATH = 1.0  # s; whom a stuck disk holds up in the kernel is dead only once that lets go of it


class _Beside(BaseProcess):
    """One that ends by itself once it is let go of, and otherwise is killed.

    Args:
        patience: s that it may take to end.
        target: what it runs, given `arguments`.
        name: for whoever looks.
    """

    def __init__(
        self,
        patience: float,
        target: Callable[..., object],
        arguments: tuple[Any, ...],
        name: str | None = None,
    ) -> None:
        super().__init__(target=target, args=arguments, name=name, daemon=True)
        self._patience = patience

    def join(self, timeout: float | None = None) -> None:
        """Wait for its end; unless told how long, with patience, and then kill it.

        When this process ends, `multiprocessing` calls this for whoever is left.
        """
        if timeout is not None:
            super().join(timeout)
            return
        try:
            super().join(self._patience)
        finally:
            self.kill()
            super().join(_DEATH)


class ForkedBeside(_Beside, ForkProcess):
    """Forked from this process."""
