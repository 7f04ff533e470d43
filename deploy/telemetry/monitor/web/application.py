"""The web application: a page of static files, and one websocket for frames and what viewers ask for."""

from __future__ import annotations

import asyncio
from hmac import compare_digest
from pathlib import Path
from typing import Any
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

from deploy.telemetry.monitor.steerable import Steerable
from deploy.telemetry.monitor.web.stream import FrameStream
from protocol.messages import Id
from protocol.requests.goals import GoalOrder, GoalReply
from protocol.requests.steering import Steer
from protocol.wire.reader import DAMAGED

PAGE = Path(__file__).parent / "page"
_HEADERS = {
    "content-security-policy": "default-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; frame-ancestors 'none'",
    "cache-control": "no-cache",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
}


_ONLY_LOOKS = "this page may only look: to steer, open the address that was printed, with its token"
_ANSWER = 10.0  # s that the source may take over an order
_SILENCE = "no answer from the run; the order may yet reach it"
_UNANSWERED = GoalReply(False, text=_SILENCE)


class Directed(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Who is to go where."""

    robot: Id
    order: GoalOrder


class Asked(Steer, frozen=True):
    """What a viewer may ask for: steering, where one robot is to go, and an emergency stop or its release."""

    goal: Directed | None = None
    halt: bool | None = None


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


def application(source: Steerable, hosts: list[str], token: str) -> Starlette:
    """The page for `source`, answering under the host names `hosts` only; who has `token` may steer."""
    stream = FrameStream(source)

    async def live(socket: WebSocket) -> None:
        if not _same_origin(socket):
            await socket.close(1008)
            return
        await socket.accept()
        may_steer = _knows(socket, token)
        await _tell(socket, "welcome", may_steer=may_steer)
        stream.enter()
        try:
            async with asyncio.TaskGroup() as tasks:
                sending = tasks.create_task(_send(socket, stream))
                await _listen(socket, source, tasks, may_steer=may_steer)
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
        if epoch == known:  # else it is of who was there before
            await socket.send_text(frame.decode())


async def _listen(socket: WebSocket, source: Steerable, tasks: asyncio.TaskGroup, *, may_steer: bool) -> None:
    """Pass on what the viewer asks for; returns when it leaves. What is malformed, or asked by who only may
    look, is told and ignored."""
    while True:
        await asyncio.sleep(0)  # what has arrived is read without a pause: nobody else would have a turn
        try:
            text = await socket.receive_text()
            asked = msgspec.json.decode(text, type=Asked)
            if not may_steer:
                await _tell(socket, "refused", text=_ONLY_LOOKS)
            elif asked.halt is not None:
                tasks.create_task(_halt(socket, source, asked.halt))
            elif asked.goal is not None:
                tasks.create_task(_order(socket, source, asked.goal))
            else:
                source.steer(Steer(asked.pause, asked.step, asked.speed))
        except WebSocketDisconnect:
            return
        except (*DAMAGED, KeyError) as error:
            await _tell(socket, "refused", text=str(error))


async def _halt(socket: WebSocket, source: Steerable, halt: bool) -> None:
    """Pass on an emergency stop or its release; frames tell that it is in force."""
    try:
        async with asyncio.timeout(_ANSWER):
            refusal = await asyncio.wrap_future(source.halt(halt))
    except TimeoutError:
        refusal = _SILENCE
    await _tell(socket, "halted", text=refusal)


async def _order(socket: WebSocket, source: Steerable, directed: Directed) -> None:
    """Pass on where a robot is to go, and say what was answered."""
    try:
        async with asyncio.timeout(_ANSWER):
            reply = await asyncio.wrap_future(source.order(directed.robot, directed.order))
    except TimeoutError:
        reply = _UNANSWERED
    told = {"robot": directed.robot, "points": directed.order.points}
    await _tell(socket, "answer", **told, accepted=reply.accepted, text=reply.text)


async def _tell(socket: WebSocket, kind: str, **content: Any) -> None:
    await socket.send_text(msgspec.json.encode({"kind": kind, **content}).decode())
