"""A cable carries, is pulled, and holds on to nothing of connections that have ended."""

from __future__ import annotations

import asyncio
import gc
import socket
import struct
import threading
from collections.abc import Iterator
from contextlib import closing, suppress

import pytest

from deploy.studies.endurance.cable import HERE, Cable

CONNECTIONS = 100
PATIENCE = 10.0  # s


@pytest.fixture
def router() -> Iterator[tuple[str, int]]:
    """Sends back what it hears, and is made of plain sockets: it leaves no cycles."""
    with socket.create_server((HERE, 0)) as server:
        threading.Thread(target=_serve, args=(server,), daemon=True).start()
        yield server.getsockname()
        server.shutdown(socket.SHUT_RDWR)


def _serve(server: socket.socket) -> None:
    with suppress(OSError):
        while True:
            threading.Thread(target=_echo, args=(server.accept()[0],), daemon=True).start()


def _echo(connection: socket.socket) -> None:
    with connection, suppress(OSError):
        while data := connection.recv(1 << 16):
            connection.sendall(data)


def connect(port: int) -> socket.socket:
    return socket.create_connection((HERE, port), PATIENCE)


def asked(connection: socket.socket, word: bytes) -> bytes:
    connection.sendall(word)
    return connection.recv(len(word))


def kill(connection: socket.socket) -> None:
    """As the kernel does for a process that is killed while something is under way to it."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    connection.close()


def test_nothing_passes_while_it_is_out(router: tuple[str, int]) -> None:
    async def drive() -> None:
        cable = Cable(router)
        with closing(await asyncio.to_thread(connect, await cable.lay())) as robot:
            assert await asyncio.to_thread(asked, robot, b"one") == b"one"
            cable.pull(0.2)
            began = asyncio.get_running_loop().time()
            assert await asyncio.to_thread(asked, robot, b"two") == b"two"
            assert asyncio.get_running_loop().time() - began >= 0.2

    asyncio.run(asyncio.wait_for(drive(), PATIENCE))


def test_nothing_is_kept_of_connections_that_have_ended(router: tuple[str, int]) -> None:
    """Also where Python does not search for garbage by itself, which it may not do for hours."""

    def use(port: int, number: int) -> None:
        robot = connect(port)
        assert asked(robot, b"word") == b"word"
        (kill if number % 2 else socket.socket.close)(robot)

    async def drive() -> None:
        cable = Cable(router)
        port = await cable.lay()
        counts = []
        for number in range(CONNECTIONS):
            if number % 10 == 0:
                cable.pull(0.01)
            await asyncio.to_thread(use, port, number)
            counts.append(len(gc.get_objects()))
        while len(gc.get_objects()) >= counts[CONNECTIONS // 4] + CONNECTIONS:
            await asyncio.sleep(0.01)  # a connection ends some time after its robot

    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        asyncio.run(asyncio.wait_for(drive(), 3 * PATIENCE))
    finally:
        gc.enable()
        gc.unfreeze()
