"""What runs on a host of a test: its processes (`start TABLE`), and an observer (`observe ENDPOINT RUN`)."""

import json
import pickle
import sys
from contextlib import suppress
from pathlib import Path

from deploy.processes.supervisor import Supervisor
from deploy.processes.table import WORLD
from protocol.bus.bus import Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode
from protocol.keys import world_key
from protocol.messages import Result, Truth
from protocol.process.signals import STOP, Stopped


def start(table: str) -> None:
    """Start pickled rows in order, each once the one before is ready; say `ready`, and wait for SIGTERM."""
    with suppress(Stopped), STOP.listening(), Supervisor() as supervisor:
        for row in pickle.loads(Path(table).read_bytes()):
            supervisor.start([row])
            if row.reports and row.name != WORLD:  # which tells what came of the run
                supervisor.report(row.name, 30.0)
        print("ready", flush=True)
        STOP.wait()


def observe(endpoint: str, run: str) -> None:
    """Tell every truth, and at last the result, a line of JSON each."""
    bus = ZenohBus(Connection(connect=(endpoint,), timeout=60.0))
    for stream in ("truth", "result"):
        bus.subscribe(world_key(run, stream))
    while True:
        event = bus.receive(60.0)
        assert isinstance(event, Sample), "the world said nothing for a minute"
        message = decode(event.key, event.payload)
        if isinstance(message, Truth):
            positions = dict(zip(message.robots, message.positions, strict=True))
            print(json.dumps({"tick": message.tick, "positions": positions}), flush=True)
        elif isinstance(message, Result):
            print(json.dumps({"report": json.loads(message.report)}), flush=True)
            break
    bus.close()


if __name__ == "__main__":
    {"start": start, "observe": observe}[sys.argv[1]](*sys.argv[2:])
