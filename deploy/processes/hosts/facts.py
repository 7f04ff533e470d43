"""The far end of `disknav setup hosts`: what this host is like, and what time it is whenever it is asked."""

from __future__ import annotations

import platform
import shutil
import socket
import sys
import tempfile
import time
from contextlib import ExitStack

import msgspec

from deploy.software.provenance import SOFTWARE, code_digest


class Facts(msgspec.Struct, frozen=True):
    """What a host says about itself."""

    code: str  # digest of this software's sources
    python: str
    compiled: bool
    free: int  # bytes, where a run's files go
    port: str  # why its router could not listen; empty if it could


def main(listen: str, port: str) -> int:
    """Listen where the router will, say the facts, then the time (s, monotonic) for each line heard."""
    with ExitStack() as stack:
        why = ""
        try:
            stack.enter_context(_listener(listen, int(port)))
        except OSError as error:
            why = str(error)
        import agents.robot

        facts = Facts(
            code_digest(SOFTWARE),
            platform.python_version(),
            not (agents.robot.__file__ or "").endswith(".py"),
            shutil.disk_usage(tempfile.gettempdir()).free,
            why,
        )
        print(msgspec.json.encode(facts).decode(), flush=True)
        for _ in sys.stdin:
            print(time.monotonic(), flush=True)
    return 0


def _listener(address: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    return socket.create_server((address, port), family=family)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
