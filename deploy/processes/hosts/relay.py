"""What is said on another host, labelled with its name: on the terminal here, and in a file of that host."""

from __future__ import annotations

import logging
import threading
from pathlib import Path
from typing import IO

import msgspec

from protocol.codec import DAMAGED
from protocol.process.log import LOG, Line, Speaker, lines, words

_LONGEST = 1 << 16  # bytes of a line that are read at once
_LAST_WORDS = 1.0  # s
_decoder = msgspec.json.Decoder(Line)


class Relay:
    """Takes what the processes of one host, its shell and ssh write to standard error.

    A host that was taken over can say what it likes here; it is labelled as that host's, and cannot steer
    the terminal.

    Raises:
        UsageError: nothing can be written to `folder`.
    """

    def __init__(self, host: str, run: str, folder: Path | None) -> None:
        self._host, self._speaker = host, Speaker(run, host)
        self._logger = logging.Logger(f"{LOG.name}.{host}")
        self._logger.addHandler(words(self._speaker))
        if folder is not None:
            self._logger.addHandler(lines(self._speaker, folder / f"{host}.jsonl"))
        self._thread: threading.Thread | None = None

    def follow(self, stream: IO[bytes]) -> None:
        """Take everything from `stream`, on a thread of its own."""
        self._thread = threading.Thread(
            target=self._read, args=(stream,), name=f"log of {self._host}", daemon=True
        )
        self._thread.start()

    def end(self) -> None:
        """Wait for the last words of a host that is gone."""
        if self._thread is not None:
            self._thread.join(_LAST_WORDS)

    def take(self, said: bytes) -> None:
        """Take one line: of a log, or plain text."""
        try:
            line = _decoder.decode(said)
            text = printable(line.text).replace("\n", f"\n{self._host}: ")
            record = msgspec.structs.replace(line, text=text).record(self._host)
        except DAMAGED:
            self._logger.warning(printable(said.decode(errors="replace")))
        else:
            self._logger.handle(record)

    def _read(self, stream: IO[bytes]) -> None:
        with stream:
            while said := stream.readline(_LONGEST):
                self.take(said)


def printable(said: str) -> str:
    """The text without what would steer a terminal; a traceback keeps its lines."""
    return "".join(each if each.isprintable() or each == "\n" else " " for each in said).rstrip()
