"""Cables that can be pulled: a process that every robot's link leads through.

While a cable is out nothing passes and nobody is told, as with a real one: both ends find out by themselves.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import signal
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection as Channel
from types import TracebackType
from typing import Any, Self

from deploy.run.topology import Routed
from protocol.errors import ProcessError
from protocol.process.title import entitle

_PATIENCE = 30.0  # s for the process to come up, and to end
_HERE = "127.0.0.1"
_CHUNK = 1 << 16  # bytes


class Cables:
    """The launcher's side: a cable from each robot to a router; a context manager, which ends the process.

    Raises:
        ProcessError: the process has ended.
    """

    def __init__(self, routed: Routed, robots: Sequence[int], run: str) -> None:
        """`routed`: the router at the other end."""
        protocol, _, address = routed.endpoint.partition("/")
        host, _, port = address.rpartition(":")
        context = multiprocessing.get_context("spawn")
        self._channel, theirs = context.Pipe()
        self._process = context.Process(
            target=main, args=(theirs, (host, int(port)), tuple(robots), run), name="cables", daemon=True
        )
        self._process.start()
        theirs.close()
        self._routed, self._protocol = routed, protocol

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._channel.close()
        self._process.join(_PATIENCE)
        self._process.kill()
        self._process.join()

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid or 0

    def topology(self) -> Routed:
        """The same fleet, with every robot at its cable."""
        try:
            if self._channel.poll(_PATIENCE):
                ports = self._channel.recv()
                detours = {robot: f"{self._protocol}/{_HERE}:{port}" for robot, port in ports.items()}
                return replace(self._routed, detours=detours)
        except (EOFError, ConnectionError):
            pass  # told below
        raise ProcessError("the process that links lead through says nothing; see above")

    def pull(self, robot: int, seconds: float) -> None:
        """Take a robot's cable out for a while."""
        try:
            self._channel.send((robot, seconds))
        except ConnectionError as error:
            raise ProcessError("the process that links lead through is gone") from error


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
