"""The web application: a page of static files, and one websocket for frames and steering."""

from __future__ import annotations

import asyncio
from hmac import compare_digest
from pathlib import Path
from urllib.parse import urlsplit

import msgspec
from starlette.applications import Starlette
from starlette.datastructures import MutableHeaders
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.routing import Mount, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from deploy.monitor.source import Source
from deploy.monitor.web.stream import FrameStream
from protocol.steering import Steer

PAGE = Path(__file__).parent / "page"
_HEADERS = {
    "content-security-policy": "default-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; frame-ancestors 'none'",
    "cache-control": "no-cache",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
}


_ONLY_LOOKS = "this page may only look: to steer, open the address that was printed, with its token"


class FixedHeaders:
    """Adds `_HEADERS` to every HTTP response: nothing is loaded from elsewhere, nothing is cached."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(_HEADERS)
            await send(message)

        await self._app(scope, receive, send_with_headers if scope["type"] == "http" else send)


def application(source: Source, hosts: list[str], token: str) -> Starlette:
    """The page for `source`, answering under the host names `hosts` only; who has `token` may steer."""
    stream = FrameStream(source)

    async def live(socket: WebSocket) -> None:
        if not _same_origin(socket):
            await socket.close(1008)
            return
        await socket.accept()
        stream.enter()
        try:
            async with asyncio.TaskGroup() as tasks:
                sending = tasks.create_task(_send(socket, stream))
                await _listen(socket, source, may_steer=_knows(socket, token))
                sending.cancel()
        except* WebSocketDisconnect:
            pass
        finally:
            stream.leave()

    return Starlette(
        routes=[
            WebSocketRoute("/live", live),
            Mount("/", StaticFiles(directory=PAGE, html=True)),
        ],
        middleware=[Middleware(TrustedHostMiddleware, allowed_hosts=hosts), Middleware(FixedHeaders)],
    )


def _same_origin(socket: WebSocket) -> bool:
    """Another site's page, open in the same browser, must not steer a fleet."""
    origin = socket.headers.get("origin")
    return origin is None or urlsplit(origin).netloc == socket.headers.get("host")


def _knows(socket: WebSocket, token: str) -> bool:
    return compare_digest(socket.query_params.get("token", "").encode(), token.encode())


async def _send(socket: WebSocket, stream: FrameStream) -> None:
    number, known = 0, -1
    while True:
        number, epoch, frame = await stream.after(number)
        if epoch != known:
            known, overview = stream.overview()
            await socket.send_text(overview.decode())
        await socket.send_text(frame.decode())


async def _listen(socket: WebSocket, source: Source, *, may_steer: bool) -> None:
    """Pass on what the viewer asks for; returns when it leaves. What is malformed, or asked by who only may
    look, is told and ignored."""
    while True:
        try:
            text = await socket.receive_text()
            order = msgspec.json.decode(text, type=Steer)
            if may_steer:
                source.steer(order)
            else:
                await _refuse(socket, _ONLY_LOOKS)
        except WebSocketDisconnect:
            return
        except (msgspec.DecodeError, KeyError) as error:
            await _refuse(socket, str(error))


async def _refuse(socket: WebSocket, text: str) -> None:
    await socket.send_text(msgspec.json.encode({"kind": "refused", "text": text}).decode())
