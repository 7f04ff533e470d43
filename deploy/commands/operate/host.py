"""`disknav host`: the far end of `disknav run --hosts`, which ssh starts."""

from __future__ import annotations

import os
import sys


def host() -> None:
    """Start processes for a launcher on another host, by way of standard input and output."""
    from deploy.processes.spawn import environment

    # A fresh interpreter: processes that are forked carry neither this command line nor its libraries.
    os.execve(sys.executable, [sys.executable, "-m", "deploy.processes.hosts.remote"], environment())
