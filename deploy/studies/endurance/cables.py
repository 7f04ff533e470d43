"""A process that every robot's link leads through, so that it can be cut."""

from __future__ import annotations

import asyncio
import gc
import signal
from collections.abc import Sequence
from dataclasses import replace
from multiprocessing.connection import Connection as Channel
from typing import Any

from deploy.run.topology import Routed
from deploy.studies.endurance.cable import HERE, Cable
from deploy.studies.endurance.side_process import SideProcess
from protocol.process.signals import ENDING
from protocol.process.title import entitle


class Cables(SideProcess):
    """The launcher's side: a cable from each robot to a router.

    Raises:
        ProcessError: the process has ended.
    """

    def __init__(self, routed: Routed, robots: Sequence[int], run: str) -> None:
        """`routed`: the router at the other end."""
        super().__init__("cables", main, routed.endpoint.address, tuple(robots), run)
        self._routed, self._protocol = routed, routed.endpoint.protocol

    def topology(self) -> Routed:
        """The same fleet, with every robot at its cable."""
        ports = self._hear()
        detours = {robot: f"{self._protocol}/{HERE}:{port}" for robot, port in ports.items()}
        return replace(self._routed, detours=detours)

    def pull(self, robot: int, seconds: float) -> None:
        """Take a robot's cable out for a while."""
        self._say((robot, seconds))


def main(channel: Channel[Any, Any], router: tuple[str, int], robots: tuple[int, ...], run: str) -> None:
    """Lay the cables, tell their ports, and pull those that the other end says, until that is gone."""
    entitle("cables", run)
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN)  # the parent alone decides what a Ctrl-C means
    gc.freeze()  # a cable searches for garbage when a connection ends: not among what is there for good
    asyncio.run(_serve(channel, {robot: Cable(router) for robot in robots}))


async def _serve(channel: Channel[Any, Any], cables: dict[int, Cable]) -> None:
    told, gone = asyncio.Event(), False
    channel.send({robot: await cable.lay() for robot, cable in cables.items()})
    asyncio.get_running_loop().add_reader(channel.fileno(), told.set)
    while not gone:
        await told.wait()
        told.clear()
        try:
            while channel.poll():
                robot, seconds = channel.recv()
                cables[robot].pull(seconds)
        except (EOFError, ConnectionError):
            gone = True
