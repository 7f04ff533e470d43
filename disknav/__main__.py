"""The command `disknav`, once it is sure that the packages which it is made of are its own."""

from __future__ import annotations

import signal
import sys

from disknav import ownership

_FAULT = 3  # as in deploy/output.py, which may be a stranger's


def main() -> None:
    """Entry point of the command."""
    # Until `deploy.cli.main`, whose package may be a stranger's, listens to them.
    signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGTERM, signal.SIGHUP))
    try:
        ownership.check()
    except ownership.ForeignPackageError as error:
        print(f"disknav: {error}", file=sys.stderr)
        sys.exit(_FAULT)
    from deploy.cli.main import main

    main()


if __name__ == "__main__":
    main()
