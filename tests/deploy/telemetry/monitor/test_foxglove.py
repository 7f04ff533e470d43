"""The live connection for Foxglove, spoken to as Foxglove does; and the layout that goes with it."""

import json
import struct
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from deploy.run.local import LocalFleet
from deploy.telemetry.monitor.foxglove import FoxgloveServer
from deploy.telemetry.scene import TOPICS, measures
from protocol.messages import Truth
from protocol.operations import Steer
from tests.deploy.telemetry.monitor.watched import ring, running, watch_local
from tests.until import PATIENCE, until

LAYOUT = Path(__file__).parents[4] / "docs" / "guides" / "foxglove-layout.json"
_DATA = struct.Struct("<BIQ")  # opcode, subscription, time in ns


@contextmanager
def viewer(server: FoxgloveServer) -> Iterator[tuple[ClientConnection, dict[str, Any]]]:
    """A viewer and the channels that it was offered, by topic."""
    with connect(server.address, subprotocols=[Subprotocol("foxglove.sdk.v1")]) as client:
        offered: dict[str, Any] = {}
        while len(offered) < len(TOPICS):
            told = client.recv(timeout=PATIENCE)
            channels = json.loads(told).get("channels", []) if isinstance(told, str) else []
            offered |= {channel["topic"]: channel for channel in channels}
        yield client, offered


def subscribed(client: ClientConnection, channel: dict[str, Any]) -> Iterator[tuple[int, bytes]]:
    wish = {"op": "subscribe", "subscriptions": [{"id": 5, "channelId": channel["id"]}]}
    client.send(json.dumps(wish))
    while True:
        data = client.recv(timeout=PATIENCE)
        if isinstance(data, bytes) and data[0] == 1:
            _, subscription, time = _DATA.unpack_from(data)
            assert subscription == 5
            yield time, data[_DATA.size :]


def test_foxglove_sees_a_run_live_and_after_its_end() -> None:
    fleet = LocalFleet(ring(), "r")
    watcher = watch_local(fleet.network, "r")
    with closing(FoxgloveServer(watcher, "r", 0)) as server:
        watcher.steer(Steer(speed=1.0))
        with running(fleet):
            until(lambda: watcher.snapshot()["tick"] >= 2)
            with viewer(server) as (client, offered):
                assert offered["/scene/robots"]["schemaName"] == "foxglove.SceneUpdate"
                assert offered["/tf"]["schemaName"] == "foxglove.FrameTransforms"
                measures = subscribed(client, offered["/measures"])
                times = [next(measures)[0] for _ in range(4)]
                assert times == sorted(times)
                assert times[-1] > times[0]
            watcher.steer(Steer(speed=0.0))
            until(lambda: watcher.snapshot()["verdict"])
        with viewer(server) as (client, offered):  # nothing is published any more
            _, scene = next(subscribed(client, offered["/scene/robots"]))
            assert [each["id"] for each in json.loads(scene)["entities"]] == [
                f"robot {i}" for i in range(1, 5)
            ]


def test_the_layout_shows_topics_that_there_are() -> None:
    panels = json.loads(LAYOUT.read_text())["configById"]
    assert panels["3D!scene"]["topics"].keys() <= TOPICS.keys()
    paths = [
        path["value"] for name, panel in panels.items() if name.startswith("Plot") for path in panel["paths"]
    ]
    assert {"/measures.clearance", "/measures.log_potential"} <= set(paths)
    assert set(paths) <= {f"/measures.{name}" for name in measures(Truth(0, (), (), 0.0, 1.0))}
