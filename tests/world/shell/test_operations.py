"""What operators ask for is written down: who was sent where, who came and went, every emergency stop."""

from __future__ import annotations

import json

import pytest

from deploy.library.load import load
from protocol.bus.bus import Request
from protocol.bus.local import LocalNetwork
from world.shell.node import WorldNode

ASKED = (
    ("robot/2/goal", {"points": [[0.05, 0.02]]}),
    ("robot/2/goal", {"points": [[9.0, 0.0]]}),
    ("world/fleet", {"remove": 1}),
    ("world/things", {"place": {"center": [0.0, 0.25], "radius": 0.01}}),
    ("world/halt", {"halt": True}),
    ("world/halt", {"halt": True}),
    ("world/halt", {"halt": False}),
    ("world/halt", {}),
)


def test_a_log_holds_every_order_and_a_person_hears_of_every_stop() -> None:
    said: list[str] = []
    noted: list[str] = []
    bus = LocalNetwork().connect()
    world = WorldNode(bus, "r", [load("swap-2")], say=said.append, note=noted.append)
    replies: list[bytes] = []
    for key, request in ASKED:
        payload = json.dumps(request).encode() if request else b""
        world.handle(Request(f"disknav/r/{key}", payload, replies.append))
    assert len(replies) == len(ASKED)
    assert said == ["tick 0: emergency stop", "tick 0: released"]
    assert noted[0] == "tick 0: robot 2 is sent to [(0.05, 0.02)]"
    assert noted[1].startswith("tick 0: robot 2 is sent to [(9.0, 0.0)]: refused, ")
    assert noted[2].startswith("tick 0: robot 1 goes")
    assert noted[3].startswith("tick 0: a thing comes")
    assert len(noted) == 4


@pytest.mark.parametrize(
    ("stream", "payload"),
    [("things", b'{"tak": 99}'), ("fleet", b'{"ad": 1}'), ("halt", b'{"halt": 1}'), ("fleet", b"{")],
)
def test_what_is_no_request_is_answered_in_its_form(stream: str, payload: bytes) -> None:
    world = WorldNode(LocalNetwork().connect(), "r", [load("swap-2")])
    replies: list[bytes] = []
    world.handle(Request(f"disknav/r/world/{stream}", payload, replies.append))
    reply = json.loads(replies[0])
    assert reply.get("reply") == "refused" or reply["accepted"] is False
    assert stream in reply["text"]
