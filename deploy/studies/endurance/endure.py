"""One trial of endurance: a real-time fleet that never rests, and what its processes hold on to."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table

from deploy.run.fleet import ENOUGH, Fleet
from deploy.run.options import RunOptions
from deploy.run.reports import Report
from deploy.studies.endurance import flatness
from deploy.studies.endurance.judgement import Criterion, criteria_table, passed, plain
from deploy.studies.endurance.samples import Samples
from deploy.studies.endurance.workload import workload
from protocol.messages import Clock

LAUNCHER = "launcher"
_SAMPLES = 240  # a trial, at least 0.25 s and at most 10 s apart
_SPEED = 0.05  # m/s; half a minute a run, each of which leaves its report (10 KB) in world and launcher
_PACE = 0.99  # of the ticks that real time has


@dataclass(frozen=True)
class Trial:
    """What is asked of a fleet."""

    robots: int
    minutes: float
    options: RunOptions  # real time


def endure(trial: Trial, tell: Callable[[float], None]) -> dict[str, Any]:
    """Keep the fleet moving for its minutes, and judge; the result in plain types.

    Raises:
        ProcessError, BusError: the fleet could not be started.
    """
    seconds = 60.0 * trial.minutes
    samples = Samples(min(10.0, max(0.25, seconds / _SAMPLES)))
    began: float | None = None  # with the first tick

    def watch(clock: Clock) -> None:
        nonlocal began
        if began is None or (clock.tick == 0 and clock.run_number == 0):
            began = time.monotonic()

    def enough() -> bool:
        samples.take({**fleet.pids(), LAUNCHER: os.getpid()})
        if began is None:
            return False
        done = time.monotonic() - began
        tell(done / seconds)
        return done >= seconds

    scenarios = workload(trial.robots, speed=_SPEED, seconds=seconds)
    with Fleet(scenarios, trial.options, watch=watch) as fleet:
        reports = fleet.execute(enough)
        fleet.processes()
    return result(trial, reports, samples, scenarios[0].time.step)


def result(trial: Trial, reports: list[Report], samples: Samples, step: float) -> dict[str, Any]:
    """What came of a trial; `step` is the period of the clock, s."""
    ticks, wall = (sum(report[name] for report in reports) for name in ("ticks", "wall_time"))
    missed = sum(report["missed_commands"] for report in reports)
    verdicts = Counter(report["verdict"] for report in reports[:-1])
    last = reports[-1]
    criteria = [
        Criterion("no command missed", f"{missed} of {ticks * trial.robots}", missed == 0 and ticks > 0),
        Criterion(
            "real time kept", f"{ticks / wall if wall else 0.0:.2f} of {1.0 / step:g} ticks a second",
            ticks * step >= _PACE * wall > 0.0,
        ),
        Criterion("nothing touched", f"{(n := _sum(reports, 'collisions'))} collisions", n == 0),
        Criterion(
            "all arrived in every run that ended", f"{verdicts['arrived']} of {verdicts.total()}",
            verdicts["arrived"] == verdicts.total() and last["reason"] == ENOUGH,
        ),
        *_flatness(samples),
    ]  # fmt: skip
    return {
        "trial": "endurance",
        "robots": trial.robots,
        "minutes": trial.minutes,
        "transport": trial.options.transport,
        "secure": trial.options.secure is not None,
        "runs": len(reports),
        "verdicts": dict(verdicts),
        "ended": last["reason"],
        "ticks": ticks,
        "missed_commands": missed,
        "passed": passed(criteria),
        "criteria": plain(criteria),
        "processes": {name: _trend(series) for name, series in samples.of.items()},
        "samples": {name: {q: list(v) for q, v in series.items()} for name, series in samples.of.items()},
    }


def _sum(reports: list[Report], name: str) -> int:
    return int(sum(report[name] for report in reports))


def _flatness(samples: Samples) -> list[Criterion]:
    trends = {name: flatness.memory(s["time"], s["private_mb"]) for name, s in samples.of.items()}
    rises = {name: trend for name, trend in trends.items() if trend is not None}
    too_few = not rises
    worst = max(rises, key=lambda name: rises[name].rise - rises[name].allowed, default="")
    listing = [
        Criterion(
            "memory flat in its second half",
            "too short to tell" if too_few else f"{worst} {rises[worst].rise:+.2f} MB at worst",
            None if too_few else all(trend.flat for trend in rises.values()),
        )
    ]
    for quantity, words in (("handles", "file handles flat"), ("threads", "threads flat")):
        found = {name: flatness.steady(series[quantity]) for name, series in samples.of.items()}
        growing = [name for name, flat in found.items() if flat is False]
        text = "too short to tell" if too_few else ", ".join(growing) or "in every process"
        listing.append(Criterion(words, text, None if too_few else not growing))
    return listing


def _trend(series: dict[str, Any]) -> dict[str, Any]:
    trend = flatness.memory(series["time"], series["private_mb"])
    return {
        **{name: _ends(series[name]) for name in ("private_mb", "resident_mb")},
        "memory": None if trend is None else {**trend._asdict(), "flat": trend.flat},
        **{name: _ends(series[name]) for name in ("handles", "threads")},
    }


def _ends(values: Sequence[float]) -> dict[str, float]:
    return {"first": values[0], "most": max(values), "last": values[-1]}


def table(outcome: dict[str, Any]) -> RenderableType:
    """What a person wants to know."""
    listing = Table(box=None, padding=(0, 1), header_style="dim")
    listing.add_column("process", no_wrap=True)
    for column in ("private, MB", "rise, MB", "an hour", "allowed", "resident, MB", "handles", "threads"):
        listing.add_column(column, justify="right", no_wrap=True)
    for name, process in outcome["processes"].items():
        trend = process["memory"]
        cells = ["-"] * 3 if trend is None else [
            f"{trend['rise']:+.2f}", f"{trend['per_hour']:+.1f}", f"{trend['allowed']:.2f}"
        ]  # fmt: skip
        listing.add_row(
            name,
            f"{process['private_mb']['last']:.1f}",
            *cells,
            f"{process['resident_mb']['last']:.1f}",
            *(f"{process[q]['first']:.0f} to {process[q]['last']:.0f}" for q in ("handles", "threads")),
        )
    criteria = [Criterion(**each) for each in outcome["criteria"]]
    return Group(listing, criteria_table(criteria))
