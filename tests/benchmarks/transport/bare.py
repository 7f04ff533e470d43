"""The floor: a fleet's lock-step messages with nothing computed, on raw zenoh and on `ZenohBus`.

Per tick the world sends every robot a measurement; every robot that has it sends its state to all
others; every robot that has all states sends the world its command; the world waits for all
commands. Same keys, payload sizes and phases as a real fleet.

    python -m tests.benchmarks.transport.bare --robots 6 16
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import zenoh

from deploy.processes.spawn import Spawner
from deploy.processes.supervisor import Supervisor
from deploy.processes.table import Process, router
from protocol.bus.bus import Presence, Sample
from protocol.bus.connection import Connection, configuration
from protocol.bus.zenoh import ZenohBus
from protocol.keys import every_robot, robot_key, robot_token, robot_tokens, world_key
from protocol.streams import STREAMS

RUN = "bare"
_MODULES = (
    "numpy",
    "zenoh",
    "protocol.bus.zenoh",
    "deploy.processes.router",
    "tests.benchmarks.transport.bare",
)


class Payloads(NamedTuple):
    """What is sent, of the sizes that a fleet's messages have; the first byte says of which kind it is."""

    tick: bytes
    state: bytes
    command: bytes


class Rate(NamedTuple):
    """What `robots` cost: ticks per second, and processor time of all processes per tick (ms).

    The second hardly depends on what else the machine does.
    """

    ticks_per_second: float
    cpu_ms: float


def rate(robots: int, seconds: float = 3.0, bus: Literal["raw", "bus"] = "raw") -> Rate:
    """Lock-step ticks of `robots` processes through a router, on raw zenoh or on `ZenohBus`."""
    from tests.benchmarks.transport.payloads import payloads  # here, so that the processes do without a fleet

    module, say = "tests.benchmarks.transport.bare", payloads(robots)
    with Supervisor(Spawner(_MODULES)) as supervisor:
        supervisor.start([router(Connection("router"))])
        endpoint = supervisor.report("router", 10.0)
        supervisor.start(
            Process(f"robot-{i}", f"{module}:{bus}_robot", (endpoint, i, robots, say))
            for i in range(1, robots + 1)
        )
        world = Process("world", f"{module}:{bus}_world", (endpoint, robots, seconds, say), reports=True)
        supervisor.start([world])
        ticks, frequency = map(float, supervisor.report("world", seconds + 30.0).split())
        cpu = sum(usage.cpu_s for usage in supervisor.usage())
    return Rate(frequency, 1000.0 * cpu / ticks)


def timed(tick: Callable[[], None], seconds: float) -> str:
    """Tick for a tenth of `seconds` to warm up, then for all of them; "ticks in all, ticks per second"."""
    total = 0
    for duration in (0.1 * seconds, seconds):
        begin, ticks = time.perf_counter(), 0
        while (elapsed := time.perf_counter() - begin) < duration:
            tick()
            ticks += 1
        total += ticks
    return f"{total} {ticks / elapsed}"


# -- raw zenoh: one FIFO per subscription, received in the order of the phases, as in zenoh's examples


def _open(endpoint: str) -> zenoh.Session:
    config = configuration(Connection(connect=(endpoint,)))
    return zenoh.open(zenoh.Config.from_json5(json.dumps(config)))


def _publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    return session.declare_publisher(
        key,
        congestion_control=zenoh.CongestionControl.BLOCK,
        express=False,
        allowed_destination=zenoh.Locality.REMOTE,
    )


def raw_robot(endpoint: str, robot: int, robots: int, say: Payloads) -> int:
    """One robot on raw zenoh; ends when it is told to."""
    session = _open(endpoint)
    fifo: zenoh.handlers.FifoChannel[zenoh.Sample] = zenoh.handlers.FifoChannel(4 * robots + 64)
    measurements = session.declare_subscriber(robot_key(RUN, robot, "tick"), fifo)
    states = session.declare_subscriber(every_robot(RUN, "state"), fifo)
    state = _publisher(session, robot_key(RUN, robot, "state"))
    command = _publisher(session, robot_key(RUN, robot, "command"))
    token = session.liveliness().declare_token(robot_token(RUN, robot, "1"))
    while token is not None:
        measurements.recv().payload.to_bytes()
        state.put(say.state)
        for _ in range(robots - 1):
            states.recv().payload.to_bytes()
        command.put(say.command)
    return 0


def raw_world(
    endpoint: str, robots: int, seconds: float, say: Payloads, report: Callable[[str], None]
) -> int:
    """The world on raw zenoh; reports the rate."""
    session = _open(endpoint)
    commands = session.declare_subscriber(
        every_robot(RUN, "command"), zenoh.handlers.FifoChannel(4 * robots + 64)
    )
    measurements = [_publisher(session, robot_key(RUN, i, "tick")) for i in range(1, robots + 1)]
    tokens = session.liveliness().declare_subscriber(robot_tokens(RUN), history=True)
    for _ in range(robots):
        tokens.recv()

    def tick() -> None:
        for measurement in measurements:
            measurement.put(say.tick)
        for _ in range(robots):
            commands.recv().payload.to_bytes()

    report(timed(tick, seconds))
    return 0


# -- the same through ZenohBus, every sample by way of `receive`


def bus_robot(endpoint: str, robot: int, robots: int, say: Payloads) -> int:
    """One robot on `ZenohBus`; ends when it is told to."""
    bus = ZenohBus(Connection(connect=(endpoint,)))
    measurement = robot_key(RUN, robot, "tick")
    bus.subscribe(measurement)
    bus.subscribe(*[robot_key(RUN, i, "state") for i in range(1, robots + 1) if i != robot])
    state = bus.publisher(STREAMS["state"], robot_key(RUN, robot, "state"))
    command = bus.publisher(STREAMS["command"], robot_key(RUN, robot, "command"))
    bus.announce(robot_token(RUN, robot, "1"))
    heard = 0  # states of this tick; those of the fast come before the own measurement
    measured = False
    while True:
        event = bus.receive(10.0)
        if not isinstance(event, Sample):
            return 1
        if event.key == measurement:
            state(say.state)
            measured = True
        else:
            heard += 1
        if measured and heard == robots - 1:
            heard, measured = 0, False
            command(say.command)


def bus_world(
    endpoint: str, robots: int, seconds: float, say: Payloads, report: Callable[[str], None]
) -> int:
    """The world on `ZenohBus`; reports the rate."""
    bus = ZenohBus(Connection(connect=(endpoint,)))
    bus.subscribe(*[robot_key(RUN, i, "command") for i in range(1, robots + 1)])
    stream = STREAMS["tick"]
    measurements = [bus.publisher(stream, robot_key(RUN, i, "tick")) for i in range(1, robots + 1)]
    bus.watch(robot_tokens(RUN))

    def hear(kind: type[Any]) -> None:
        for _ in range(robots):
            if not isinstance(bus.receive(20.0), kind):
                raise RuntimeError(f"{world_key(RUN, 'clock')}: no {kind.__name__} within 20 s")

    def tick() -> None:
        for measurement in measurements:
            measurement(say.tick)
        hear(Sample)

    hear(Presence)
    report(timed(tick, seconds))
    return 0


def main() -> None:
    """Print both rates and their ratio for each number of robots."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=[6, 16, 32, 64])
    parser.add_argument("--seconds", type=float, default=3.0)
    options = parser.parse_args()
    print(f"{'':>6} {'raw zenoh':^19} {'ZenohBus':^19}   ratio")
    print(f"robots {'ticks/s   cpu ms':>19} {'ticks/s   cpu ms':>19} ticks/s  cpu")
    for robots in options.robots:
        raw, bus = rate(robots, options.seconds), rate(robots, options.seconds, "bus")
        columns = " ".join(f"{each.ticks_per_second:10.1f} {each.cpu_ms:8.2f}" for each in (raw, bus))
        ratios = f"{bus.ticks_per_second / raw.ticks_per_second:7.2f} {raw.cpu_ms / bus.cpu_ms:4.2f}"
        print(f"{robots:6d} {columns} {ratios}", flush=True)


if __name__ == "__main__":
    main()
