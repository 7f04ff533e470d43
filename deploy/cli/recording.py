"""`disknav recording`: inspect, draw and replay recordings."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.cli import options
from deploy.output import bar, check_target, check_text, grid, is_standard_output, print_whole, write_json
from protocol.errors import RecordingError
from protocol.keys import checked_run
from protocol.process.signals import STOP

if TYPE_CHECKING:  # reading needs numpy, other commands do not
    from rich.table import Table

    from deploy.telemetry.recording.reader import Recording

app = typer.Typer(name="recording", help="Inspect, draw and replay recordings.", no_args_is_help=True)


@app.command()
def info(recording: options.RecordingFile, json_file: options.JsonFile = None) -> None:
    """Print scenario, verdict and streams of a recording, and whether its trajectory matches the result.

    Example: disknav recording info figure-1.mcap
    """
    from rich.console import Group

    check_text(json_file, recording)
    found = _read(recording)
    summary = _summary(found)
    write_json({**summary, "streams": dict(found.counts), "result": found.result}, json_file)
    if not is_standard_output(json_file):
        print_whole(Group(grid(summary), _streams(found)))


@app.command()
def plot(
    recording: options.RecordingFile,
    out: Annotated[
        Path, options.out("Picture to write: .png, .svg, .pdf, or an animation: .gif, .webp, .mp4.")
    ],
    until: Annotated[
        float | None, typer.Option(min=0.0, help="Draw only this many simulated seconds.")
    ] = None,
    width: Annotated[
        int | None, typer.Option(min=100, max=2000, help="Width of an animation, pixels; default 440.")
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(min=1.0, help="Longest duration of an animation; a longer run is sped up. Default 10."),
    ] = None,
) -> None:
    """Draw a recording: paths and disks, clearance and phi over time, and the age of received information.

    Examples: disknav recording plot figure-1.mcap -o figure-1.pdf;
    disknav recording plot figure-2.mcap --until 2.5 -o blocked.png;
    disknav recording plot figure-1.mcap -o figure-1.webp --width 300 --seconds 5
    """
    from deploy.telemetry.plot import draw

    draw.check(out, recording)
    if out.suffix not in draw.ANIMATIONS:
        options.refuse(
            {"--width": width, "--seconds": seconds}, "it is for an animation: name a .gif or .webp"
        )
    found = _read(recording)
    if until is not None:
        found = draw.until(found, until)
    with bar(f"drawing {out.name}") as progress:
        draw.draw(found, out, progress, width, seconds)


@app.command()
def replay(
    recording: options.RecordingFile,
    zenoh: Annotated[
        bool, typer.Option("--zenoh", help="Publish the messages over zenoh, under the recorded keys.")
    ] = False,
    router: Annotated[
        str | None,
        typer.Option(
            metavar="ENDPOINT",
            help="Publish through the router that listens at this endpoint; by default a new one.",
        ),
    ] = None,
    run: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Name of the run to publish as; by default the recorded one."),
    ] = None,
    speed: Annotated[
        float | None, typer.Option(min=0.0, help="Simulated seconds per second; 0: unlimited. Default 1.")
    ] = None,
    web: Annotated[
        bool, typer.Option("--web", help="Show it on the live page; its address is printed.")
    ] = False,
    ros2: Annotated[
        Path | None, typer.Option(metavar="FILE.mcap", help="Write the poses tick by tick, for ROS 2 tools.")
    ] = None,
) -> None:
    """Recompute a recording's trajectory and compare it with the result; replay it on request.

    Example: disknav recording replay figure-1.mcap --zenoh --router tcp/127.0.0.1:7447 --speed 2

    Exit status: 0 same trajectory, or no result to compare with; 3 another trajectory.
    """
    from deploy.telemetry.recording.replay import export, verify

    if not (zenoh or router is not None or web):
        options.refuse({"--run": run, "--speed": speed}, "nothing is replayed: add --zenoh or --web")
    pace, run = 1.0 if speed is None else speed, None if run is None else checked_run(run)
    check_target(ros2, "write ROS 2 messages", recording)
    found = _read(recording)
    trajectory = verify(found)
    lacking = "not compared: this file lacks the world's result or the beginning of the run"
    known = trajectory and f"{trajectory.sha256}, as in the result{trajectory.remark}"
    typer.echo(f"trajectory {known or lacking}")
    if ros2 is not None:
        export(found, ros2)
    if zenoh or router is not None:
        _publish(found, router, run, pace)
    if web:
        _show(found, run, pace)


def _read(path: Path) -> Recording:
    from deploy.telemetry.recording.reader import read

    with bar(f"reading {path.name}") as progress:
        return read(path, progress)


def _summary(recording: Recording) -> dict[str, str]:
    scenario, result = recording.scenario, recording.result or {}
    ticks = int(recording.trajectory.ticks[-1])
    return {
        "scenario": f"{scenario.name}, {len(scenario.robots)} robots, seed {scenario.seed}",
        "run": recording.run,
        "verdict": f"{result.get('verdict', 'none: no result was recorded')}  {result.get('reason', '')}",
        "ticks": f"{ticks}, {ticks * scenario.time.step:g} s simulated",
        "messages": f"{recording.counts.total()}",
        "file": "cut short: the messages after the cut are lost" if recording.cut else "complete",
        "trajectory": _check(recording),
    }


def _check(recording: Recording) -> str:
    from deploy.telemetry.recording.replay import recomputed

    try:
        found = recomputed(recording)
    except RecordingError as error:
        return f"cannot be checked: {error}"
    said = {None: "no result to compare with", found.sha256: "as in the result"}
    recorded = (recording.result or {}).get("trajectory_sha256")
    return f"{found.sha256}, {said.get(recorded, 'NOT the one in the result')}{found.remark}"


def _streams(recording: Recording) -> Table:
    from rich.table import Table

    table = Table(box=None, padding=(0, 2), header_style="dim")
    table.add_column("key")
    table.add_column("messages", justify="right")
    table.add_column("per tick", justify="right")
    ticks = max(1, int(recording.trajectory.ticks[-1]))
    for key, count in sorted(recording.counts.items()):
        table.add_row(key, str(count), f"{count / ticks:.2f}")
    return table


def _publish(recording: Recording, router: str | None, run: str | None, speed: float) -> None:
    from deploy.processes.router import listening
    from deploy.telemetry.recording.replay import publish
    from protocol.bus.connection import Connection, Endpoint
    from protocol.bus.zenoh import ZenohBus

    if router is None:
        bus, endpoint = listening(Connection("router"))
    else:
        endpoint = Endpoint(router)
        bus = ZenohBus(Connection(connect=(endpoint,)))
    with closing(bus), bar(f"replaying {recording.path.name}") as progress:
        typer.echo(f"replaying run {run or recording.run} at {endpoint}")
        publish(recording, bus, run, speed=speed, progress=progress)


def _show(recording: Recording, run: str | None, speed: float) -> None:
    from deploy.telemetry.monitor.watcher import Player
    from deploy.telemetry.monitor.web import Server

    heard = ((entry.time, entry.message) for entry in recording.entries)
    player = Player(recording.scenario, run or recording.run, heard, speed=speed, paused=True)
    with closing(player), closing(Server(player)) as server:
        typer.echo(f"{server.link}  (Resume plays it; Ctrl-C ends it)")
        STOP.wait()
