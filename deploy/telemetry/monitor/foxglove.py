"""A live connection for Foxglove: the scene of a run over its WebSocket protocol, on the loopback only."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor

from deploy.telemetry.live import FleetView
from deploy.telemetry.monitor.watcher import Watcher
from deploy.telemetry.scene import TOPICS, FleetScene, Picture
from protocol.messages import Message
from protocol.process.installation import missing_library

try:
    from foxglove import Capability, Channel, Context, Schema, start_server
    from foxglove.websocket import ChannelView, Client, ServerListener
except ModuleNotFoundError as error:
    raise missing_library("--foxglove", "foxglove-sdk", "foxglove") from error

HOST = "127.0.0.1"


class FoxgloveServer(ServerListener):
    """Sends the scene of a watcher's view to viewers.

    Args:
        run: shown to viewers.
        port: 0: a free one. If it is taken, RuntimeError is raised.
    """

    def __init__(self, watcher: Watcher, run: str, port: int) -> None:
        self._watcher = watcher
        self._scene: FleetScene | None = None  # under the lock of the watcher's view
        self._welcoming = ThreadPoolExecutor(1, "foxglove newcomers")
        self._context = Context()  # closes its channels when it is deleted
        self._channels = {name: _channel(self._context, name) for name in TOPICS}
        self._server = start_server(
            name=f"disknav {run}",
            host=HOST,
            port=port,
            capabilities=[Capability.Time],
            server_listener=self,
            context=self._context,
        )
        self.address = f"ws://{HOST}:{self._server.port}"  # to open in Foxglove
        watcher.follow = self._follow

    def _follow(self, view: FleetView, message: Message | None) -> None:
        if view.scenario is None:
            return
        if self._scene is None or message is None:  # a scenario begins
            self._scene = FleetScene(view)
            self._log(self._scene.whole())
        else:
            self._log(self._scene.after(message))

    def close(self) -> None:
        """Disconnect all viewers and stop; may be called twice."""
        self._watcher.follow = lambda *_: None
        self._server.stop()
        self._welcoming.shutdown()

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:  # noqa: ARG002
        """Send the newest message to a new subscriber, since a topic may not change again; called by the
        server, which must not wait.
        """
        shown = self._welcoming.submit(self._watcher.change, lambda *_: self._show(channel.topic))
        shown.add_done_callback(Future.result)  # logs an error

    def _show(self, topic: str) -> None:
        if self._scene is not None:
            self._log(self._scene.latest(topic))

    def _log(self, pictures: Iterable[Picture]) -> None:
        for picture in pictures:
            self._server.broadcast_time(picture.time)
            self._channels[picture.topic].log(picture.data, log_time=picture.time)


def _channel(context: Context, name: str) -> Channel:
    topic = TOPICS[name]
    schema = Schema(name=topic.schema, encoding="jsonschema", data=topic.definition)
    return Channel(name, schema=schema, message_encoding="json", context=context)
