"""`disknav replay`: a recording over again."""

from __future__ import annotations

import threading
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.commands import options
from deploy.output.bar import bar

if TYPE_CHECKING:  # the rest of the command line does without what reading takes, numpy first of all
    from deploy.telemetry.recording.reading.reader import Recording


def replay(
    recording: options.RecordingFile,
    zenoh: Annotated[
        bool, typer.Option("--zenoh", help="Publish onto a network, under the recorded keys.")
    ] = False,
    router: Annotated[
        str | None,
        typer.Option(
            metavar="ENDPOINT",
            help="Publish through the router that listens there; listens on a port itself unless given.",
        ),
    ] = None,
    run: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Name of the run to play it as; the recorded one unless given."),
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option(min=0.0, help="Simulated seconds a second; 0 for as fast as possible, 1 unless given."),
    ] = None,
    web: Annotated[
        bool, typer.Option("--web", help="Play it on the live page; its address is printed.")
    ] = False,
    ros2: Annotated[
        Path | None,
        typer.Option(metavar="FILE.mcap", help="Write where robots were, tick by tick, for ROS 2 tools."),
    ] = None,
) -> None:
    """Recompute a recording's trajectory and compare it with the result's; play it again if asked to.

    Example: disknav replay figure-1.mcap --zenoh --router tcp/127.0.0.1:7447 --speed 2

    Exit status: 0 the same trajectory (or nothing to compare it with), 3 another one.
    """
    from deploy.telemetry.recording.reading.reader import read
    from deploy.telemetry.recording.reading.replay import verify

    if not (zenoh or router is not None or web):
        options.refuse({"--run": run, "--speed": speed}, "nothing is played: add --zenoh or --web")
    pace = 1.0 if speed is None else speed
    with bar(f"reading {recording.name}") as progress:
        found = read(recording, progress)
    trajectory = verify(found)
    if trajectory is not None:
        typer.echo(f"trajectory {trajectory.sha256}, as in the result{trajectory.remark}")
    else:
        typer.echo(
            "no trajectory hash to compare with: the result, or the beginning of the run, is not in this file"
        )
    if ros2 is not None:
        from deploy.telemetry.recording.reading.replay import export

        export(found, ros2)
    if zenoh or router is not None:
        _publish(found, router, run, pace)
    if web:
        _show(found, run, pace)


def _publish(recording: Recording, router: str | None, run: str | None, speed: float) -> None:
    from deploy.processes.router import listening
    from deploy.telemetry.recording.reading.replay import publish
    from protocol.bus.connection import Connection
    from protocol.bus.zenoh import ZenohBus
    from protocol.endpoint import Endpoint

    if router is None:
        bus, endpoint = listening(Connection("router"))
    else:
        endpoint = Endpoint(router)
        bus = ZenohBus(Connection(connect=(endpoint,)))
    with closing(bus), bar(f"replaying {recording.path.name}") as progress:
        typer.echo(f"replaying run {run or recording.run} at {endpoint}")
        publish(recording, bus, run, speed=speed, progress=progress)


def _show(recording: Recording, run: str | None, speed: float) -> None:
    from deploy.telemetry.monitor.player import Player
    from deploy.telemetry.monitor.web.server import serve_in_thread

    heard = ((entry.time, entry.message) for entry in recording.entries)
    player = Player(recording.scenario, run or recording.run, heard, speed=speed)
    with closing(player), closing(serve_in_thread(player)) as server:
        typer.echo(f"{server.link}  (Ctrl-C ends it)")
        threading.Event().wait()
