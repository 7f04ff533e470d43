"""Short programs, each in an interpreter of its own, of which nothing is left."""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

ROOT = Path(__file__).parent.parent


def ended(
    script: str | Path, *arguments: object, timeout: float = 30.0, cwd: Path = ROOT
) -> subprocess.CompletedProcess[str]:
    """Outcome of a program, its text or file, in a folder, after it and all processes that it started have
    ended; all are killed in any case.

    Raises:
        subprocess.TimeoutExpired: one of them has not ended within `timeout` s.
    """
    program = ["-c", script] if isinstance(script, str) else [str(script)]
    command = [sys.executable, *program, *map(str, arguments)]
    with subprocess.Popen(
        command,
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,  # which all of them hold
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            said = process.communicate(timeout=timeout)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    return subprocess.CompletedProcess(command, process.returncode, *said)
