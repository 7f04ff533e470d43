"""Watchers on both buses, the web server, the replayed page and the terminal table."""

from __future__ import annotations

import asyncio
import io
import json
import re
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import closing
from math import inf
from typing import Any

import pytest
import zenoh
from rich.console import Console
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from deploy.local import LocalFleet
from deploy.monitor import terminal
from deploy.monitor.attachment import attach
from deploy.monitor.player import Player
from deploy.monitor.server import Server, serve_in_thread
from deploy.monitor.source import SharedView
from deploy.monitor.stream import FrameStream
from deploy.monitor.watcher import Watcher, watch_local
from deploy.options import fresh_run_name
from deploy.router import listening
from protocol.bus import Event, Presence, Sample
from protocol.bus_local import LocalNetwork
from protocol.bus_zenoh import ZenohBus
from protocol.codec import encode
from protocol.connection import Connection
from protocol.errors import BusError, UsageError
from protocol.joining import Overview, encode_reply
from protocol.keys import parse, robot_key, world_key
from protocol.messages import Clock, Truth
from protocol.steering import Steer
from protocol.streams import STREAMS
from tests.deploy.watched import PATIENCE, ring, running, served, until


def live(server: Server, **options: Any) -> ClientConnection:
    return connect(server.address.replace("http", "ws") + "/live", **options)


def news(socket_: ClientConnection, kind: str, condition: Callable[[Any], Any] = lambda _: True) -> Any:
    """The next message of a kind that fulfils a condition."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        message = json.loads(socket_.recv(timeout=PATIENCE))
        if message["kind"] == kind and condition(message):
            return message
    raise AssertionError(f"no such {kind}")


def test_a_watcher_sees_what_the_world_judged() -> None:
    fleet = LocalFleet([ring()], "r")
    watcher = watch_local(fleet.network, "r")
    report = fleet.execute()[0]
    frame = watcher.snapshot()
    assert frame["verdict"] == report["verdict"] == "arrived"
    assert frame["tick"] == report["ticks"]
    assert frame["smallest"] >= report["min_clearance"] - 1e-12
    assert {row["status"] for row in frame["robots"]} == {"at goal"}
    assert watcher.overview()["history"][-1][2] == pytest.approx(report["phi"]["last"])


def test_a_watcher_does_not_change_a_run() -> None:
    alone, watched = LocalFleet([ring()], "r"), LocalFleet([ring()], "r")
    watch_local(watched.network, "r")
    assert alone.execute()[0]["trajectory_sha256"] == watched.execute()[0]["trajectory_sha256"]


def test_a_watcher_follows_one_scenario_after_another() -> None:
    fleet = LocalFleet([ring(4), ring(4, limit=0.2)], "r")
    watcher = watch_local(fleet.network, "r")
    fleet.execute()
    assert watcher.overview()["epoch"] == 2
    assert watcher.snapshot()["verdict"] == "timeout"


def test_a_watcher_hears_only_what_the_network_may_drop() -> None:
    class Listening:
        def __init__(self) -> None:
            self.heard: list[str] = []

        def subscribe(self, key_expression: str) -> None:
            self.heard.append(key_expression)

        def watch(self, key_expression: str) -> None:
            pass

    bus = Listening()
    Watcher(bus, "r")  # type: ignore[arg-type]  # a bus that only listens is all it needs here
    streams = [parse(key.replace("*", "1")).stream for key in bus.heard]
    assert streams
    assert not [stream for stream in streams if STREAMS[stream].reliable]


def test_pause_step_and_resume_reach_a_run_in_this_process() -> None:
    fleet = LocalFleet([ring()], "r")
    watcher = watch_local(fleet.network, "r", speed=1.0)
    with running(fleet):
        until(lambda: watcher.snapshot()["tick"] >= 2)
        watcher.steer(Steer(pause=True))
        until(lambda: watcher.snapshot()["phase"] == "paused")
        held = watcher.snapshot()["tick"]
        watcher.steer(Steer(step=3))
        until(lambda: watcher.snapshot()["tick"] >= held + 3)
        assert watcher.snapshot()["tick"] <= held + 4  # one may have been open when it was asked
        watcher.steer(Steer(pause=False, speed=0.0))
        until(lambda: watcher.snapshot()["verdict"] == "arrived")


def test_a_killed_robot_is_an_alarm_within_two_seconds() -> None:
    fleet = LocalFleet([ring(kill=2)], "r")
    watcher = watch_local(fleet.network, "r", speed=1.0)
    with running(fleet):
        until(lambda: fleet.robots[2].node is None)
        until(lambda: watcher.snapshot()["robots"][1]["alarm"], 2.0)
        assert [row["alarm"] for row in watcher.snapshot()["robots"]] == [False, True, False, False]


# -- the web server


def test_the_page_is_told_an_overview_and_then_frames_at_a_bounded_rate() -> None:
    fleet = LocalFleet([ring()], "r")
    watcher = watch_local(fleet.network, "r", speed=0.5)
    with running(fleet), served(watcher) as server, live(server) as viewer:
        overview = news(viewer, "overview", lambda it: it["scenario"])
        assert [robot["id"] for robot in overview["robots"]] == [1, 2, 3, 4]
        first = news(viewer, "frame")
        began, count = time.monotonic(), 0
        while time.monotonic() < began + 1.0:
            last = news(viewer, "frame")
            count += 1
        assert count <= 21
        assert last["tick"] > first["tick"]
        assert last["robots"][0]["distance"] < first["robots"][0]["distance"]


def test_a_viewer_can_hold_the_run_and_let_it_go() -> None:
    fleet = LocalFleet([ring()], "r")
    watcher = watch_local(fleet.network, "r", speed=1.0)
    with running(fleet), served(watcher) as server, live(server) as viewer:
        news(viewer, "frame", lambda it: it["tick"] >= 2)
        viewer.send('{"pause": true}')
        held = news(viewer, "frame", lambda it: it["phase"] == "paused")
        later = [news(viewer, "frame")["tick"] for _ in range(6)][-1]
        assert later - held["tick"] <= 1
        viewer.send('{"pause": "perhaps"}')
        assert "pause" in news(viewer, "refused")["text"]
        viewer.send('{"pause": false, "speed": 0}')
        assert news(viewer, "frame", lambda it: it["verdict"])["verdict"] == "arrived"


def test_a_viewer_that_does_not_read_holds_up_nobody() -> None:
    fleet = LocalFleet([ring()], "r")
    watcher = watch_local(fleet.network, "r", speed=0.3)
    with (
        running(fleet),
        served(watcher) as server,
        live(server, max_queue=1, close_timeout=0.1) as asleep,
        live(server) as viewer,
    ):
        news(asleep, "overview")
        first = news(viewer, "frame")["tick"]
        assert news(viewer, "frame", lambda it: it["tick"] > first + 10)["phase"] == "running"


def test_a_slow_viewer_gets_the_newest_frame_and_not_those_between() -> None:
    async def scene() -> tuple[int, int]:
        stream = FrameStream(SharedView("r"))  # type: ignore[arg-type]  # nobody steers here
        stream.enter()
        number, _, _ = await stream.after(0)
        await asyncio.sleep(0.3)
        following, _, _ = await stream.after(number)
        stream.leave()
        return number, following

    number, following = asyncio.run(scene())
    assert following >= number + 3


@pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:1", "null"])
def test_a_page_of_another_site_cannot_steer(origin: str) -> None:
    with served(watch_local(LocalNetwork(), "r")) as server:
        with pytest.raises(WebSocketException), live(server, origin=origin) as viewer:
            viewer.recv(timeout=PATIENCE)
        with live(server, origin=server.address) as viewer:
            assert news(viewer, "frame")["phase"] == "searching"


def test_only_the_own_host_name_is_answered() -> None:
    with served(watch_local(LocalNetwork(), "r")) as server:
        request = urllib.request.Request(server.address, headers={"Host": "evil.example"})
        with pytest.raises(urllib.error.HTTPError, match="400"):
            urllib.request.urlopen(request, timeout=PATIENCE)


def fetch(url: str) -> str:
    with urllib.request.urlopen(url, timeout=PATIENCE) as response:
        assert "default-src 'self'" in response.headers["content-security-policy"]
        return str(response.read().decode())


def test_every_file_of_the_page_is_served_and_none_comes_from_elsewhere() -> None:
    with served(watch_local(LocalNetwork(), "r")) as server:
        page = fetch(server.address)
        seen, pending = set(), set(re.findall(r'(?:src|href)="([^"]+)"', page))
        while pending:
            name = pending.pop()
            seen.add(name)
            text = fetch(f"{server.address}/{name}")
            assert not re.findall(r"https?://(?!www\.w3\.org/2000/svg)", text), name
            pending |= set(re.findall(r'from "\./([^"]+)"', text)) - seen
    assert {"main.js", "workspace.js", "styles/theme.css", "icon.svg"} <= seen


def test_a_taken_port_is_named() -> None:
    source = watch_local(LocalNetwork(), "r")
    with served(source) as server, pytest.raises(UsageError, match=re.escape(server.address.rsplit(":")[-1])):
        serve_in_thread(source, int(server.address.rsplit(":")[-1]))


def test_a_server_that_is_closed_is_gone() -> None:
    server = serve_in_thread(watch_local(LocalNetwork(), "r"))
    with live(server) as viewer:
        news(viewer, "frame")
        server.close()
        server.close()
        with pytest.raises(WebSocketException):
            news(viewer, "never")
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", int(server.address.rsplit(":")[-1])), PATIENCE)


def test_without_the_web_libraries_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "uvicorn", None)
    with pytest.raises(UsageError, match=r"pip install \"disknav\[web\]\""):
        serve_in_thread(watch_local(LocalNetwork(), "r"))


# -- from outside, over zenoh


class World:
    """The least that a watcher needs of a world, on a bus of its own."""

    def __init__(self, endpoint: str, run: str) -> None:
        self.run = run
        self.bus = ZenohBus(Connection(connect=(endpoint,)))
        self.bus.serve(world_key(run, "scenario"))
        self.clock = self.bus.publisher(STREAMS["clock"], world_key(run, "clock"))
        self.truth = self.bus.publisher(STREAMS["truth"], world_key(run, "truth"))
        self.bus.announce(world_key(run, "alive"))
        self.tick = 0
        self.asked = False

    def turn(self) -> None:
        """Answer whoever asks, and let a tick go by."""
        event: Event | None = self.bus.receive(0.02)
        if event is not None and not isinstance(event, Sample | Presence):
            event.reply(encode_reply(Overview(ring(2), True)))
            self.asked = True
        self.clock(encode(Clock(self.tick, 0.05 * self.tick, (1, 2), (), "")))
        self.tick += 1
        self.truth(encode(Truth(self.tick, (1, 2), ((0.001 * self.tick, 0.0), (0.1, 0.1)), 0.01, 0.5)))


def test_endpoint_and_run_name_are_enough_and_tokens_come_and_go() -> None:
    router, endpoint = listening(Connection("router"))
    run = fresh_run_name()
    with closing(router), closing(attach(Connection(connect=(endpoint,)), run)) as watcher:
        assert watcher.snapshot()["phase"] == "searching"  # the run begins later
        world = World(endpoint, run)
        with closing(world.bus):
            robot = ZenohBus(Connection(connect=(endpoint,)))
            robot.announce(robot_key(run, 2, "alive"))
            until(lambda: (world.turn(), watcher.snapshot()["tick"] > 3)[1])
            assert [row["alive"] for row in watcher.snapshot()["robots"]] == [None, True]
            robot.close()
            until(lambda: watcher.snapshot()["robots"][1]["status"] == "dead", 2.0)
        until(lambda: watcher.snapshot()["phase"] == "lost")
        second = World(endpoint, run)  # another world under this name: everything anew
        with closing(second.bus):
            until(lambda: (second.turn(), watcher.overview()["epoch"] == 2)[1])


@pytest.mark.process
def test_a_frozen_monitor_holds_up_nobody() -> None:
    router, endpoint = listening(Connection("router"))
    run = fresh_run_name()
    world = World(endpoint, run)
    command = [sys.executable, "-m", "deploy.cli", "monitor", "--run", run, "--router", endpoint]
    with closing(router), closing(world.bus), subprocess.Popen(command, stdout=subprocess.DEVNULL) as monitor:
        try:
            until(lambda: (world.turn(), world.asked or monitor.poll() is not None)[1], 60.0)
            assert world.asked
            monitor.send_signal(signal.SIGSTOP)
            many = tuple(range(1, 501))
            truth = encode(Truth(9, many, tuple((0.1, 0.1) for _ in many), 0.01, 0.5))
            assert longest(lambda: world.truth(truth), 3000) < 0.4  # waiting for room would take 0.5 s
        finally:
            monitor.kill()


def longest(action: Callable[[], None], times: int) -> float:
    """Seconds that the slowest of many repetitions took."""
    worst = 0.0
    for _ in range(times):
        began = time.monotonic()
        action()
        worst = max(worst, time.monotonic() - began)
    return worst


def test_links_are_read_from_the_admin_space_where_it_is_on() -> None:
    router, endpoint = with_admin_space()
    with router, closing(attach(Connection(connect=(endpoint,)), fresh_run_name())) as watcher:
        told = until(lambda: watcher.snapshot()["router"])
        assert told["zid"] == str(router.zid())
        assert len(told["links"]) == 1
        assert told["links"][0].startswith("client tcp/127.0.0.1:")
        assert "1 links" in rendered(watcher.snapshot())


def test_where_the_admin_space_is_off_nothing_is_missing() -> None:
    router, endpoint = listening(Connection("router"))
    with closing(router), closing(attach(Connection(connect=(endpoint,)), fresh_run_name())) as watcher:
        until(lambda: watcher._look_at == inf)
        assert watcher.snapshot()["router"] is None


def with_admin_space() -> tuple[zenoh.Session, str]:
    """A router as a stock one is, on a free port."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    configuration = {
        "mode": "router",
        "listen": {"endpoints": [endpoint]},
        "scouting": {"multicast": {"enabled": False}},
        "adminspace": {"enabled": True},
    }
    return zenoh.open(zenoh.Config.from_json5(json.dumps(configuration))), endpoint


def rendered(frame: dict[str, Any]) -> str:
    console = Console(record=True, width=120, file=io.StringIO())
    console.print(terminal.table(frame))
    return console.export_text()


def test_nobody_at_the_endpoint_is_an_error() -> None:
    with pytest.raises(BusError):
        attach(Connection(connect=("tcp/127.0.0.1:1",), timeout=0.2), "r")


# -- a recording, and the terminal


def entries(ticks: int) -> Iterator[tuple[float, Clock | Truth]]:
    for tick in range(ticks):
        yield 0.05 * tick, Clock(tick, 0.05 * tick, (1, 2), (), "")
        yield 0.05 * (tick + 1), Truth(tick + 1, (1, 2), ((0.0, 0.0), (0.1, 0.1)), 0.01, 0.5)
    yield 0.05 * ticks, Clock(ticks, 0.05 * ticks, (), (), "arrived")


def test_a_recording_plays_at_its_speed_and_can_be_held() -> None:
    with closing(Player(ring(2), "old", entries(400), speed=1.0)) as player:
        until(lambda: player.snapshot()["tick"] >= 2)
        player.steer(Steer(pause=True))
        held = player.snapshot()
        assert held["phase"] == "paused"
        assert not player.join(0.15)
        assert player.snapshot()["tick"] <= held["tick"] + 1
        player.steer(Steer(pause=False, speed=0.0))
        assert player.join(PATIENCE)
        assert player.snapshot()["verdict"] == "arrived"


def test_the_terminal_shows_the_same_rows_and_ends_with_the_run() -> None:
    player = Player(ring(2), "old", entries(3), speed=0.0)
    console = Console(record=True, width=120, file=io.StringIO())
    assert terminal.show(player, console) == "arrived"
    player.close()
    frame = player.snapshot()
    frame["robots"][0].update(alarm=True, status="fenced")
    text = rendered(frame)
    assert "✕ fenced" in text
    assert "smallest clearance 10.00 mm" in text
