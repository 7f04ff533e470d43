"""The web server of the live page, on a thread of its own."""

from __future__ import annotations

import socket
import threading
from secrets import token_urlsafe
from typing import TYPE_CHECKING

from deploy.telemetry.monitor.snapshot import Steerable
from protocol.errors import UsageError
from protocol.process.installation import missing_library

if TYPE_CHECKING:
    import uvicorn

HOST = "127.0.0.1"


class Server:
    """A running server.

    Attributes:
        address: where the page is, such as `http://127.0.0.1:8000`.
        link: the same with the token of this server: who opens it may steer. Browsers keep what follows `#`
            to themselves.
    """

    def __init__(self, server: uvicorn.Server, listener: socket.socket, token: str) -> None:
        host, port = listener.getsockname()[:2]
        self.address = f"http://{host}:{port}"
        self.link = f"{self.address}/#{token}"
        self._server = server
        self._thread = threading.Thread(
            target=server.run, kwargs={"sockets": [listener]}, name="live page", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Say good-bye to all viewers and stop; may be called twice."""
        self._server.should_exit = True
        self._thread.join()


def serve_in_thread(source: Steerable, port: int | None = None) -> Server:
    """Serve the live page of `source` on 127.0.0.1, on a free port unless told which.

    Raises:
        UsageError: the extra `web` is not installed, or the port is taken.
    """
    try:
        import uvicorn

        from deploy.telemetry.monitor.web.application import application
    except ImportError as error:
        raise missing_library("the live page", error.name or str(error), "web") from error
    listener = _listener(port)
    token = token_urlsafe(16)
    app = application(source, [HOST, "localhost"], token)
    config = uvicorn.Config(
        app, log_level="error", access_log=False, timeout_graceful_shutdown=1, lifespan="off"
    )
    return Server(uvicorn.Server(config), listener, token)


def _listener(port: int | None) -> socket.socket:
    try:
        return socket.create_server((HOST, port or 0), backlog=64)
    except (OSError, OverflowError) as error:
        raise UsageError(
            f"--port {port}: {error}; name another port, or none and a free one is taken"
        ) from error
