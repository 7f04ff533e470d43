"""The floor: a fleet's lock-step messages with nothing computed, on raw zenoh.

Per tick the world sends every robot a measurement; every robot that has it sends its state to all
others; every robot that has all states sends the world its command; the world waits for all
commands. Same keys, payload sizes and phases as a real fleet.
"""

import faulthandler
import json
import time
from collections.abc import Callable
from typing import NamedTuple

import zenoh

from deploy.processes.spawn import Process, Spawner
from deploy.processes.supervisor import Supervisor
from deploy.processes.table import router
from protocol.bus.connection import Connection, configuration
from protocol.keys import every_robot, robot_key, robot_token, robot_tokens

RUN = "bare"
_MODULES = ("numpy", "zenoh", "protocol.bus.zenoh", "deploy.processes.router", "tests.benchmarks.bare")


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


def rate(robots: int, say: Payloads, seconds: float = 3.0) -> Rate:
    """Lock-step ticks of `robots` processes through a router, on raw zenoh."""
    module = "tests.benchmarks.bare"
    with Supervisor(Spawner(_MODULES)) as supervisor:
        supervisor.start([router(Connection("router"))])
        endpoint = supervisor.report("router", 10.0)
        supervisor.start(
            Process(f"robot-{i}", f"{module}:raw_robot", (endpoint, i, robots, say))
            for i in range(1, robots + 1)
        )
        world = Process("world", f"{module}:raw_world", (endpoint, robots, seconds, say), reports=True)
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
    """The world on raw zenoh; reports the rate. It ends where it waits for too long, and shows where."""
    faulthandler.dump_traceback_later(seconds + 20.0, exit=True)
    session = _open(endpoint)
    commands = session.declare_subscriber(
        every_robot(RUN, "command"), zenoh.handlers.FifoChannel(4 * robots + 64)
    )
    measurements = [_publisher(session, robot_key(RUN, i, "tick")) for i in range(1, robots + 1)]
    while len(list(session.liveliness().get(robot_tokens(RUN)))) < robots:
        pass

    def tick() -> None:
        for measurement in measurements:
            measurement.put(say.tick)
        for _ in range(robots):
            commands.recv().payload.to_bytes()

    report(timed(tick, seconds))
    return 0
