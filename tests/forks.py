"""Commands of disknav, each in a fork of one process that has imported what they all need.

A command then takes the time of its own work only: an interpreter takes longer to import than most commands
to do theirs. That the command starts by itself, too, is seen where processes of its own are started.
"""

import json
import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parent.parent
_LASTING = 10.0  # s, at most, until it ends by itself


class Forks:
    """The process that forks; it ends with `close`."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def __call__(self, *words: object, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
        """Run a command to its end, in a folder."""
        call = [str(word) for word in words]
        with TemporaryDirectory() as folder:
            said = [Path(folder, name) for name in ("stdout", "stderr")]
            print(json.dumps([call, str(cwd), *map(str, said)]), file=self._process.stdin, flush=True)
            status = int(self._process.stdout.readline())
            return subprocess.CompletedProcess(call, status, *(each.read_text() for each in said))

    def close(self) -> None:
        """End it, and whatever command it waits for."""
        self._process.stdin.close()
        try:
            self._process.wait(_LASTING)
        except subprocess.TimeoutExpired:
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()


def main() -> None:
    """Fork for each line on standard input, and answer with the status."""
    import deploy.cli.main
    import deploy.run.execute  # noqa: F401
    from deploy.library.load import load
    from disknav.__main__ import main as disknav

    load("figure-1")  # what checks a scenario is built for the first one
    for line in sys.stdin:
        words, folder, *said = json.loads(line)
        child = os.fork()
        if child == 0:
            _become(words, folder, said)
            disknav()
            return
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


def _become(words: list[str], folder: str, said: list[str]) -> None:
    """Be as the interpreter is that a shell in this folder starts."""
    os.chdir(folder)
    sys.argv, sys.path[0] = ["disknav", *words], folder
    for number, path in enumerate([os.devnull, *said]):
        opened = os.open(path, os.O_RDONLY if number == 0 else os.O_WRONLY | os.O_CREAT)
        os.dup2(opened, number)
        os.close(opened)


if __name__ == "__main__":
    main()
