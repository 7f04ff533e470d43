"""A process beside the fleet that a study talks to over a pipe."""

from __future__ import annotations

from collections.abc import Callable
from multiprocessing import Pipe
from multiprocessing.util import Finalize
from types import TracebackType
from typing import Any, Self

from deploy.run.interruption import undisturbed
from protocol.bus.drive import uninterrupted
from protocol.errors import ProcessError
from protocol.process.beside import SpawnedBeside

_PATIENCE = 30.0  # s for the process to say something
_LEAVING = 5.0  # s for it to end; nothing is lost if it is killed


class SideProcess:
    """The launcher's side; a context manager, which ends the process.

    Args:
        name: of the process.
        main: what it runs, until the other end of the channel that it is given first is gone.
        arguments: what it is given besides.
    """

    def __init__(self, name: str, main: Callable[..., None], *arguments: Any) -> None:
        self._channel, theirs = Pipe()
        Finalize(self, self._channel.close, exitpriority=0)  # at exit, who is left would be waited for
        self._process = SpawnedBeside(_LEAVING, main, (theirs, *arguments), name)
        with uninterrupted():  # whoever has begun is known
            self._process.start()
        theirs.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with undisturbed():
            self._channel.close()
            self._process.join()

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid or 0

    def _say(self, word: Any) -> None:
        try:
            self._channel.send(word)
        except ConnectionError as error:
            raise ProcessError(f"the process {self._process.name!r} is gone") from error

    def _hear(self) -> Any:
        """What it says next.

        Raises:
            ProcessError: nothing; it has ended, or takes too long.
        """
        try:
            if self._channel.poll(_PATIENCE):
                return self._channel.recv()
        except (EOFError, ConnectionError):
            self._process.join(_PATIENCE)
        status = self._process.exitcode
        raise ProcessError(
            f"the process {self._process.name!r} sends nothing (exit status {status}); see above"
        )
