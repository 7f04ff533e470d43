"""A cable that can be pulled: from one port of this host to a router.

While it is out nothing passes and nobody is told, as with a real one: both ends find out by themselves.
"""

from __future__ import annotations

import asyncio
import gc
from contextlib import suppress

HERE = "127.0.0.1"
_CHUNK = 1 << 16  # bytes


class Cable:
    """Leads every connection to its near end on to `router`, a host and a port."""

    def __init__(self, router: tuple[str, int]) -> None:
        self._router = router
        self._whole = asyncio.Event()
        self._whole.set()

    async def lay(self) -> int:
        """Returns the port of the near end, on `HERE`."""
        self._server = await asyncio.start_server(self._connect, HERE, 0)
        port: int = self._server.sockets[0].getsockname()[1]
        return port

    def pull(self, seconds: float) -> None:
        """Take it out for a while."""
        self._whole.clear()
        asyncio.get_running_loop().call_later(seconds, self._whole.set)

    async def _connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await self._whole.wait()
        try:
            far_reader, far_writer = await asyncio.open_connection(*self._router)
        except OSError:
            writer.close()
        else:
            await asyncio.gather(self._carry(reader, far_writer), self._carry(far_reader, writer))
        # A stream is a cycle. One that lived long waits for a search among all objects, which takes
        # hundreds of others to come about: hours, in which what ended would look like a leak.
        asyncio.get_running_loop().call_soon(gc.collect)

    async def _carry(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with suppress(OSError):
            while data := await reader.read(_CHUNK):
                await self._whole.wait()
                writer.write(data)
                await writer.drain()
        writer.close()
