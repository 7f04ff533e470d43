"""A host that is well until told (SIGUSR1) not to be: `liar.py COMMAND...` stands before COMMAND."""

import os
import select
import signal
import struct
import subprocess
import sys

from deploy.processes.spawn import Exited, encode_news

_LIE = encode_news(Exited(999_999, 0, 0.0, 0.0))  # of a process that was not asked for


def main(*command: str) -> int:
    """Pass on what the command says until the signal; then lie, and say nothing more."""
    told, telling = os.pipe()
    signal.signal(signal.SIGUSR1, lambda *_: os.write(telling, b"!"))
    with subprocess.Popen(command, stdout=subprocess.PIPE, bufsize=0) as host:
        while told not in (ready := select.select([host.stdout, told], [], [])[0]):
            said = os.read(host.stdout.fileno(), 1 << 16) if ready else b""
            if not said:
                return host.wait()
            os.write(1, said)
        os.write(1, struct.pack("!i", len(_LIE)) + _LIE)
        return host.wait()  # once the launcher has hung up


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
