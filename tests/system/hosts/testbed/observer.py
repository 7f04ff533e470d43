"""Run on one host of a test: tells what the world publishes, a line of JSON each."""

import json
import sys

from protocol.bus.bus import Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode
from protocol.keys import world_key
from protocol.messages import Result, Truth


def main(endpoint: str, run: str) -> None:
    """Tell every truth, and at last the result."""
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
    main(*sys.argv[1:])
