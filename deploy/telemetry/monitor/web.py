"""The live page: routes, snapshots streamed to viewers, and a server in a thread."""

from __future__ import annotations

import asyncio
import socket as socketlib
import threading
import time
from functools import partial
from hmac import compare_digest
from pathlib import Path
from secrets import token_urlsafe
from typing import Any
from urllib.parse import urlsplit

import msgspec

from deploy.telemetry.monitor.snapshot import Source
from deploy.telemetry.monitor.watcher import Player, Watcher
from protocol.codec import DAMAGED
from protocol.errors import MessageError
from protocol.operations import Outcome, read_operation, read_steer
from protocol.process.installation import missing_library
from protocol.scenario.model import Operation

try:
    import uvicorn
    from starlette.applications import Starlette
    from starlette.middleware import Middleware
    from starlette.middleware.trustedhost import TrustedHostMiddleware
    from starlette.routing import Mount, WebSocketRoute
    from starlette.staticfiles import StaticFiles
    from starlette.websockets import WebSocket, WebSocketDisconnect
except ModuleNotFoundError as error:
    raise missing_library("the live page", error.name or str(error), "web") from error

HOST = "127.0.0.1"
FRAME_PERIOD = 0.05  # s
_REST = 0.01  # s, least pause between two snapshots


class FrameStream:
    """Takes at most one snapshot per `FRAME_PERIOD` for all viewers together, and none without viewers.

    A viewer that cannot keep up misses frames; no frames are queued for it.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._newest = 0, -1, b""
        self._since = -1
        self.due = 0.0  # s, monotonic: time of the next frame

    def overview(self) -> tuple[int, bytes]:
        """Epoch and overview for a new viewer."""
        overview = self._source.overview()
        return overview["epoch"], msgspec.json.encode(overview)

    def newest(self) -> tuple[int, int, bytes]:
        """Number, epoch and text of the newest frame, which is taken now if it is due."""
        if (now := time.monotonic()) >= self.due:
            frame = self._source.snapshot(self._since)
            number, epoch, _ = self._newest
            samples = frame["samples"]
            self._since = samples[-1][0] if samples else self._since if frame["epoch"] == epoch else -1
            self._newest = number + 1, frame["epoch"], msgspec.json.encode(frame)
            self.due = max(now + FRAME_PERIOD, time.monotonic() + _REST)
        return self._newest


Steerable = Watcher | Player  # a source that takes requests of its viewers
PAGE = Path(__file__).parent / "page"
_HEADERS = {  # of every HTTP response: no foreign content, no caching
    "content-security-policy": "default-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; frame-ancestors 'none'",
    "cache-control": "no-cache",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
}


_ONLY_LOOKS = "this page may not steer: open the printed address with its token"
_ANSWER = 10.0  # s for the source to answer an order
_SILENCE = "no answer from the run, which may still receive the order"


def application(source: Steerable, hosts: list[str], token: str) -> Starlette:
    """The page for `source`, for requests to the host names `hosts` only; viewers with `token` may steer."""
    stream = FrameStream(source)

    async def live(socket: WebSocket) -> None:
        if not _same_origin(socket):
            await socket.close(1008)
            return
        await socket.accept()
        may_steer = compare_digest(socket.query_params.get("token", "").encode(), token.encode())
        await _send_event(socket, "welcome", may_steer=may_steer)
        try:
            async with asyncio.TaskGroup() as tasks:
                tasks.create_task(_send(socket, stream))
                await _listen(socket, source, tasks, may_steer=may_steer)
        except* WebSocketDisconnect:
            pass  # no task waits for an unread answer

    return Starlette(
        routes=[
            WebSocketRoute("/live", live),
            Mount("/", StaticFiles(directory=PAGE, html=True)),
        ],
        middleware=[Middleware(TrustedHostMiddleware, allowed_hosts=hosts)],
    )


def _same_origin(socket: WebSocket) -> bool:
    """Whether the page is this server's, so that another site in the same browser cannot steer a fleet."""
    origin = socket.headers.get("origin")
    return origin is None or urlsplit(origin).netloc == socket.headers.get("host")


async def _send(socket: WebSocket, stream: FrameStream) -> None:
    last, known = 0, -1
    while True:
        number, epoch, frame = stream.newest()
        if number > last and epoch != known:
            known, overview = stream.overview()
            await socket.send_text(overview.decode())
        if number > last and epoch == known:  # otherwise the frame has an earlier set of robots
            await socket.send_text(frame.decode())
        last = number
        await asyncio.sleep(max(_REST, stream.due - time.monotonic()))


async def _listen(socket: WebSocket, source: Steerable, tasks: asyncio.TaskGroup, *, may_steer: bool) -> None:
    """Forward a viewer's valid requests with the token, and refuse others; raises WebSocketDisconnect."""
    while True:
        await asyncio.sleep(0)  # lets other tasks run: buffered messages are read without a pause
        try:
            text = await socket.receive_text()
            asked = msgspec.json.decode(text)
            if not may_steer:
                await _send_event(socket, "refused", text=_ONLY_LOOKS)
            elif isinstance(asked, dict) and "steer" in asked:
                source.steer(read_steer(asked["steer"]))
            else:
                tasks.create_task(_operate(socket, source, read_operation(asked)))
        except (*DAMAGED, MessageError, KeyError) as error:
            await _send_event(socket, "refused", text=str(error))


async def _operate(socket: WebSocket, source: Steerable, operation: Operation) -> None:
    try:
        async with asyncio.timeout(_ANSWER):
            outcome = await asyncio.shield(asyncio.wrap_future(source.operate(operation)))
    except TimeoutError:
        outcome = Outcome(False, text=_SILENCE)
    asked = {action: getattr(operation, action) for action in operation.asked}
    await _send_event(socket, "answer", asked=asked, accepted=outcome.accepted, text=outcome.text)


async def _send_event(socket: WebSocket, kind: str, **content: Any) -> None:
    await socket.send_text(msgspec.json.encode({"kind": kind, **content}).decode())


class Server:
    """Serves the live page of `source` from a thread, on 127.0.0.1, by default on a free port.

    Attributes:
        address: URL of the page, such as `http://127.0.0.1:8000`.
        link: the same with this server's token, which permits steering. Browsers do not send the part after
            `#`.

    Raises:
        OSError: the port is taken.
    """

    def __init__(self, source: Steerable, port: int | None = None) -> None:
        listener = socketlib.create_server((HOST, port or 0), backlog=64)
        token, (host, port, *_) = token_urlsafe(16), listener.getsockname()
        self.address = f"http://{host}:{port}"
        self.link = f"{self.address}/#{token}"
        app = application(source, [HOST, "localhost"], token)
        config = uvicorn.Config(
            app,
            log_level="error",
            access_log=False,
            timeout_graceful_shutdown=1,
            lifespan="off",
            headers=list(_HEADERS.items()),
        )
        self._server = uvicorn.Server(config)
        serve = partial(self._server.run, [listener])
        self._thread = threading.Thread(target=serve, name="live page", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Disconnect all viewers and stop; may be called twice."""
        self._server.should_exit = True
        self._thread.join()
