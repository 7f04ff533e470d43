"""A sign of life for whoever started this process: it has its network, and its main loop goes round.

A file whose time of change moves, for the probes of container engines; and the notifications of systemd
(`sd_notify(3)`: `READY=1` once, `WATCHDOG=1` from then on).
"""

from __future__ import annotations

import os
import socket
from math import inf
from pathlib import Path
from typing import Final

from protocol.errors import ProcessError

PERIOD: Final = 1.0  # s


class Heartbeat:
    """To be called with the time, s, whenever the loop comes round; the first call says that all is ready.

    Args:
        file: is touched; none unless given.
        notify: address of systemd's socket, as `NOTIFY_SOCKET` has it; none if empty.
    """

    def __init__(self, file: Path | None = None, notify: str = "") -> None:
        self._file, self._notify = file, notify
        self._due = -inf

    def __call__(self, now: float) -> None:
        """Raises ProcessError if nobody can be told."""
        if now < self._due:
            return
        try:
            if self._file is not None:
                self._file.touch()
            if self._notify:
                self._tell(b"WATCHDOG=1" if self._due > -inf else b"READY=1")
        except OSError as error:
            raise ProcessError(f"no sign of life can be given: {error}") from error
        self._due = now + PERIOD

    def _tell(self, text: bytes) -> None:
        address = f"\0{self._notify[1:]}" if self._notify.startswith("@") else self._notify
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as sender:
            sender.sendto(text, address)


def heartbeat(file: Path | None) -> Heartbeat | None:
    """As this process was started: into `file`, and to systemd where that asked for it; None for neither."""
    notify = os.environ.get("NOTIFY_SOCKET", "")
    return Heartbeat(file, notify) if file is not None or notify else None
