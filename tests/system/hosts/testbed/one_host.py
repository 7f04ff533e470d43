"""The processes of one host: started from a pickled list of rows, in order; ended by SIGTERM.

What is needed by others on other hosts reports, and is waited for.
"""

import pickle
import sys
from contextlib import suppress
from pathlib import Path

from deploy.processes.supervisor import Supervisor
from deploy.processes.table import WORLD
from protocol.process.signals import STOP, Stopped

_START = 30.0  # s for a process to say that it is ready


def main(table: str) -> None:
    """Say `ready` once all are started, then wait for the end."""
    with suppress(Stopped), STOP.listening(), Supervisor() as supervisor:
        for row in pickle.loads(Path(table).read_bytes()):
            supervisor.start([row])
            if row.reports and row.name != WORLD:  # which tells what came of the run
                supervisor.report(row.name, _START)
        print("ready", flush=True)
        STOP.wait()


if __name__ == "__main__":
    main(*sys.argv[1:])
