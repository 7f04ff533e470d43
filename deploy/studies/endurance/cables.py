"""Cables that can be pulled: a process that every robot's link leads through.

While a cable is out nothing passes and nobody is told, as with a real one: both ends find out by themselves.
"""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection as Channel
from typing import Any

from deploy.run.topology import Routed
from deploy.studies.endurance.side_process import SideProcess
from protocol.process.title import entitle

_HERE = "127.0.0.1"
_CHUNK = 1 << 16  # bytes


class Cables(SideProcess):
    """The launcher's side: a cable from each robot to a router.

    Raises:
        ProcessError: the process has ended.
    """

    def __init__(self, routed: Routed, robots: Sequence[int], run: str) -> None:
        """`routed`: the router at the other end."""
        protocol, _, address = routed.endpoint.partition("/")
        host, _, port = address.rpartition(":")
        super().__init__("cables", main, (host, int(port)), tuple(robots), run)
        self._routed, self._protocol = routed, protocol

    def topology(self) -> Routed:
        """The same fleet, with every robot at its cable."""
        ports = self._hear()
        detours = {robot: f"{self._protocol}/{_HERE}:{port}" for robot, port in ports.items()}
        return replace(self._routed, detours=detours)

    def pull(self, robot: int, seconds: float) -> None:
        """Take a robot's cable out for a while."""
        self._say((robot, seconds))


class _Cable:
    """From one port of this host to the router."""

    def __init__(self, router: tuple[str, int]) -> None:
        self._router = router
        self._whole = asyncio.Event()
        self._whole.set()

    async def lay(self) -> int:
        """Returns the port of the near end."""
        self._server = await asyncio.start_server(self._connect, _HERE, 0)
        port: int = self._server.sockets[0].getsockname()[1]
        return port

    def pull(self, seconds: float) -> None:
        self._whole.clear()
        asyncio.get_running_loop().call_later(seconds, self._whole.set)

    async def _connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await self._whole.wait()
        try:
            far_reader, far_writer = await asyncio.open_connection(*self._router)
        except OSError:
            writer.close()
            return
        await asyncio.gather(self._carry(reader, far_writer), self._carry(far_reader, writer))

    async def _carry(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with suppress(OSError):
            while data := await reader.read(_CHUNK):
                await self._whole.wait()
                writer.write(data)
                await writer.drain()
        writer.close()


def main(channel: Channel[Any, Any], router: tuple[str, int], robots: tuple[int, ...], run: str) -> None:
    """Lay the cables, tell their ports, and pull those that the other end says, until that is gone."""
    entitle("cables", run)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent alone decides what a Ctrl-C means
    asyncio.run(_serve(channel, {robot: _Cable(router) for robot in robots}))


async def _serve(channel: Channel[Any, Any], cables: dict[int, _Cable]) -> None:
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
