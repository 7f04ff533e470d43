"""The process of one robot: its own session, its own node, and nothing else."""

from __future__ import annotations

import sys
from pathlib import Path

from agents.shell.node import RobotNode
from agents.shell.world_session import PATIENCE
from protocol.bus.bus import Heartbeat, drive, heartbeat
from protocol.bus.connection import Connection, Endpoint, credentials
from protocol.bus.zenoh import ZenohBus
from protocol.errors import DisknavError, JoinError
from protocol.keys import checked_run
from protocol.process import log
from protocol.process.log import LOG, set_process_title
from protocol.process.signals import STOP, Stopped

SUCCESS, REFUSED, FAULT = 0, 2, 3


def main(
    connection: Connection,
    run: str,
    robot: int,
    *,
    wait: float = PATIENCE,
    beat: Heartbeat | None = None,
    namespace: str | None = None,
) -> int:
    """Run robot `robot` of `run` until the world ends the run; returns the exit status.

    `wait`: as of `WorldSession`; `namespace` as of `RobotNode`.

    0: the run ended, or this process was asked to stop. 2: the world refuses this robot. 3: the network or
    the world is lost. Raises Stopped if a signal asks to end before the robot joins.
    """
    try:
        bus = ZenohBus(connection)
        node = RobotNode(
            bus, checked_run(run), robot, wait=wait, namespace=namespace, warn=LOG.warning, info=LOG.info
        )
        drive(node, bus, beat=beat)
    except JoinError as error:
        LOG.error(error)
        return REFUSED
    except DisknavError as error:
        LOG.error(error)
        return FAULT
    return SUCCESS


if __name__ == "__main__":
    STOP.listen()
    endpoint, run_name, identity, waits, keys, alive, logs, base, topics = sys.argv[1:]
    set_process_title(f"robot {identity}", run_name)
    log.begin(f"robot-{identity}", run_name, Path(logs) if logs else None, alone=True)
    proof = credentials(Path(keys), f"robot-{identity}") if keys else None
    router = Connection(connect=(Endpoint(endpoint),), timeout=float(waits), credentials=proof)
    sign = heartbeat(Path(alive) if alive else None)
    namespace = topics if base else None
    try:
        status = main(router, run_name, int(identity), wait=float(waits), beat=sign, namespace=namespace)
    except Stopped:
        STOP.exit()
    STOP.ignore()
    sys.exit(STOP.status or status)
