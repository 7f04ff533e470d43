"""The web server of the live page."""

import importlib
import json
import re
import socket
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from select import select
from typing import Any
from urllib.parse import urljoin

import pytest
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from deploy.run.local import LocalFleet
from deploy.telemetry.monitor.web import Server
from protocol.bus.local import LocalNetwork
from protocol.errors import UsageError
from tests.deploy.telemetry.monitor.watched import ring, running, watch_local
from tests.until import PATIENCE, until

pytestmark = pytest.mark.slow


@contextmanager
def driven(speed: float) -> Iterator[Server]:
    """A server for a fleet that runs."""
    fleet = LocalFleet(ring(), "r")
    watcher = watch_local(fleet.network, "r", speed=speed)
    with running(fleet), closing(Server(watcher)) as server:
        yield server


def live(server: Server, **options: Any) -> ClientConnection:
    return connect(server.link.replace("http", "ws").replace("/#", "/live?token="), **options)


def news(socket_: ClientConnection, kind: str, condition: Callable[[Any], Any] = lambda _: True) -> Any:
    def told() -> Any:
        message = json.loads(socket_.recv(timeout=PATIENCE))
        return message if message["kind"] == kind and condition(message) else None

    return until(told, what=f"no such {kind}")


def test_the_page_is_told_an_overview_and_then_frames_at_a_bounded_rate() -> None:
    with driven(0.5) as server, live(server) as viewer:
        overview = news(viewer, "overview", lambda it: it["scenario"])
        assert [robot["id"] for robot in overview["robots"]] == [1, 2, 3, 4]
        first = news(viewer, "frame")
        began, count = time.monotonic(), 0
        while time.monotonic() < began + 1.0:
            last = news(viewer, "frame")
            count += 1
        assert count <= 30  # a few may have waited
        assert last["tick"] > first["tick"]
        assert last["robots"][0]["distance"] < first["robots"][0]["distance"]


def test_a_viewer_can_hold_the_run_and_let_it_go() -> None:
    with driven(1.0) as server, live(server) as viewer:
        news(viewer, "frame", lambda it: it["tick"] >= 2)
        viewer.send('{"steer": {"pause": true}}')
        held = news(viewer, "frame", lambda it: it["phase"] == "paused")
        later = [news(viewer, "frame")["tick"] for _ in range(6)][-1]
        assert later - held["tick"] <= 1
        viewer.send('{"steer": {"pause": "perhaps"}}')
        assert "pause" in news(viewer, "refused")["text"]
        viewer.send('{"steer": {"pause": false, "speed": 0}}')
        assert news(viewer, "frame", lambda it: it["verdict"])["verdict"] == "arrived"


def test_a_viewer_releases_only_the_stops_that_it_has_been_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    with driven(0.1) as server, live(server) as viewer:
        news(viewer, "frame", lambda it: it["phase"] == "running")
        for stops, patience in ((1, 0.0), (2, PATIENCE)):
            monkeypatch.setattr("deploy.telemetry.monitor.web._ANSWER", patience)  # the first answer is late
            viewer.send('{"halt": true}')
            news(viewer, "frame", lambda it, stops=stops: (it["phase"], it["stops"]) == ("halted", stops))
        for seen, accepted in ((1, False), (2, True)):
            viewer.send(f'{{"release": {seen}}}')
            assert news(viewer, "answer", lambda it: "release" in it["asked"])["accepted"] == accepted
        news(viewer, "frame", lambda it: it["phase"] == "running")


def test_a_viewer_that_leaves_waits_for_no_answer(capfd: pytest.CaptureFixture[str]) -> None:
    watcher = watch_local(LocalNetwork(), "r")
    watcher._known = True  # nothing drives it
    with closing(Server(watcher)) as server, live(server) as viewer:
        viewer.send('{"halt": true}')
        until(lambda: not watcher._wishes.empty())
    assert capfd.readouterr().err == ""


def asleep(server: Server) -> socket.socket:
    """A viewer that asks and does not read, until the server can send it no more, and reads no more."""
    viewer = socket.socket()
    viewer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    host, port = server.address.removeprefix("http://").split(":")
    viewer.connect((host, int(port)))
    viewer.sendall(
        f"GET /live HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    assert viewer.recv(12) == b"HTTP/1.1 101"
    viewer.setblocking(False)
    nonsense = b"\x81\x81\0\0\0\0x" * 5000  # text frames, masked by nothing
    sent = 0
    while select([], [viewer], [], 0.5)[1]:
        start = sent % 7  # or a frame would be broken where the last one did not fit
        sent += viewer.send(nonsense[start:])
        assert sent < 100_000_000, "the server takes whatever comes"
    return viewer


def test_a_viewer_that_does_not_read_holds_up_no_other() -> None:
    with driven(0.3) as server, closing(asleep(server)), live(server) as viewer:
        first = news(viewer, "frame")["tick"]
        assert news(viewer, "frame", lambda it: it["tick"] > first + 10)["phase"] == "running"


def test_a_page_of_another_site_cannot_steer() -> None:
    with closing(Server(watch_local(LocalNetwork(), "r"))) as server:
        for origin in ("http://evil.example", "http://127.0.0.1:1", "null"):
            with pytest.raises(WebSocketException), live(server, origin=origin) as viewer:
                viewer.recv(timeout=PATIENCE)
        with live(server, origin=server.address) as viewer:
            assert news(viewer, "frame")["phase"] == "searching"


def test_a_viewer_without_token_may_only_look() -> None:
    with driven(1.0) as server:
        address = server.address.replace("http", "ws") + "/live"
        for query in ("", "?token=", "?token=guess", "?token=%00%ff"):
            with connect(address + query) as viewer:
                assert news(viewer, "welcome")["may_steer"] is False
                news(viewer, "frame", lambda it: it["tick"] >= 2)
                for wish in ('{"steer": {"pause": true}}', '{"goal": {"robot": 2, "points": [[0, 0]]}}'):
                    viewer.send(wish)
                    assert "may not steer" in news(viewer, "refused")["text"]
                assert news(viewer, "frame")["robots"][1]["goal"] == list(ring().spec(2).goal)
        with live(server) as viewer:
            tick = news(viewer, "frame")["tick"]
            assert news(viewer, "frame", lambda it: it["tick"] > tick + 2)["phase"] == "running"


def test_only_the_own_host_name_is_answered() -> None:
    with closing(Server(watch_local(LocalNetwork(), "r"))) as server:
        request = urllib.request.Request(server.address, headers={"Host": "evil.example"})
        with pytest.raises(urllib.error.HTTPError, match="400"):
            urllib.request.urlopen(request, timeout=PATIENCE)


def fetch(url: str) -> str:
    with urllib.request.urlopen(url, timeout=PATIENCE) as response:
        policy = response.headers["content-security-policy"]
        assert "default-src 'self'" in policy
        assert "frame-ancestors 'none'" in policy
        return str(response.read().decode())


def test_every_file_of_the_page_is_served_and_none_comes_from_elsewhere() -> None:
    with closing(Server(watch_local(LocalNetwork(), "r"))) as server:
        page = fetch(server.address)
        seen, pending = set(), set(re.findall(r'(?:src|href)="([^"]+)"', page))
        while pending:
            name = pending.pop()
            seen.add(name)
            text = fetch(f"{server.address}/{name}")
            assert not re.findall(r"https?://(?!www\.w3\.org/2000/svg)", text), name
            scripts = re.findall(r'from "(\.[^"]+)"', text)
            pending |= {urljoin(name, script) for script in scripts} - seen
    assert {"main.js", "drawing/workspace.js", "styles/theme.css", "icon.svg"} <= seen


def test_without_the_web_libraries_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    monkeypatch.delitem(sys.modules, "deploy.telemetry.monitor.web")
    with pytest.raises(UsageError, match=r"uvicorn.*pip install .*\[web\]"):
        importlib.import_module("deploy.telemetry.monitor.web")
