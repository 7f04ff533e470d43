"""One scenario from launch to result, on any transport, with recording, plot and live page."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from deploy.output import bar, write_json
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from deploy.run.result import INTERRUPTED, RunResult, complete, unjudged
from deploy.security.membership import KeyRing
from deploy.telemetry.monitor.watcher import Attachment, Watcher
from deploy.telemetry.plot.draw import draw
from deploy.telemetry.recording.reader import read
from deploy.telemetry.recording.writer import ONE_FILE
from protocol.bus.zenoh import ZenohBus
from protocol.errors import UsageError
from protocol.messages import Clock
from protocol.process.log import LOG
from protocol.process.signals import STOP, Stopped
from protocol.scenario.model import Scenario


def _live_page(fleet: Fleet | LocalFleet, options: RunOptions, stack: ExitStack) -> str:
    """Serve a page that shows `fleet`, and print its address, which permits steering, to standard error.
    Raises UsageError if the libraries of the extra `web` are not installed.
    """
    from deploy.telemetry.monitor.web import Server

    if isinstance(fleet, Fleet):
        bus = ZenohBus(fleet.topology.connection(KeyRing(options.secure).viewer))
        source: Watcher = stack.enter_context(closing(Attachment(bus, options.run)))
    else:
        here = fleet.network.connect()
        source = here.node = Watcher(here, options.run)
    server = stack.enter_context(closing(Server(source)))
    print(f"live page: {server.link}", file=sys.stderr, flush=True)
    return server.link


def execute(
    scenario: Scenario,
    options: RunOptions,
    *,
    record: Path | None = None,
    plot: Path | None = None,
    web: bool = False,
    json_file: Path | None = None,
    quiet: bool,
    on_result: Callable[[RunResult], None] = lambda _: None,
) -> RunResult:
    """Run `scenario` to its verdict. There is a result even after signals, at any time and repeatedly.

    Args:
        record, plot, json_file: files to write, which the caller has checked.
        web: whether to serve the live page.
        quiet: whether to show no progress.
        on_result: called with the result as soon as the fleet is down, before plotting.

    Raises:
        UsageError: the options do not fit together, an optional library is missing, or an output file cannot
            be written.
        ProcessError, BusError: the fleet could not be started.
    """
    unwritten: UsageError | OSError | None = None
    if scenario.is_external:
        options = replace(options, mode="realtime")  # real robots do not wait
    with STOP.listening(), ExitStack() as stack:
        recording = record
        if record is None and plot is not None:
            recording = Path(stack.enter_context(TemporaryDirectory(prefix="disknav-"))) / "run.mcap"
        with bar(scenario.name, silent=quiet) as show, ExitStack() as running:
            began = time.monotonic()
            try:
                fleet = _fleet(scenario, options, recording, partial(_show, scenario, show))
                running.enter_context(fleet)
                LOG.info(f"run {options.run!r} of {scenario.name!r} begins")
                page = _live_page(fleet, options, stack) if web else None
            except Stopped:
                ended = {"verdict": "interrupted", "reason": INTERRUPTED}
                result = complete(unjudged(scenario, None, time.monotonic() - began) | ended, options, [])
                write_json(result, json_file)
                on_result(result)
                return result
            report = fleet.execute()
            processes, recordings = fleet.processes(), fleet.recordings()
            result = complete(report, options, processes, recordings if record else [])
            LOG.info(f"verdict: {result['verdict']} {result['reason']}".rstrip())
            try:
                write_json(result, json_file)  # before the recorder is waited for
            except (UsageError, OSError) as error:
                unwritten = error
            fleet.record(result)
            running.close()
        try:
            on_result(result)
        finally:  # also if nobody reads it
            if plot is not None and not STOP.requested:
                first = 0 if options.rotation != ONE_FILE else -1  # -1: a restarted recorder has a new file
                with suppress(Stopped):
                    draw(read(recordings[first]), plot, lambda _: STOP.check())
        if unwritten is not None:
            raise unwritten
        if page is not None and sys.stdin.isatty():
            print(f"{page} stays available until Ctrl-C", file=sys.stderr, flush=True)
            STOP.wait()
    return result


def _show(scenario: Scenario, show: Callable[[float, str], None], clock: Clock) -> None:
    """Show the newest Clock."""
    limit = "" if scenario.time.endless else f" of at most {scenario.time.limit:g} s"
    figures = f"t = {clock.time:.2f} s{limit}  gap {1000 * clock.clearance:.2f} mm"
    with suppress(Stopped):  # after a signal the run still ends with a report
        show(clock.time / scenario.time.limit, f"{scenario.name}  {figures}")


def _fleet(
    scenario: Scenario, options: RunOptions, recording: Path | None, watch: Callable[[Clock], None]
) -> Fleet | LocalFleet:
    if options.transport != "local":
        return Fleet(scenario, options, watch=watch, record=recording)
    if scenario.is_external:
        raise UsageError("external bases need a network: leave out --transport local")
    clock, speed = options.lockstep, options.speed
    return LocalFleet(scenario, options.run, lockstep=clock, speed=speed, watch=watch, record=recording)
