"""What came of a trial of endurance: judged, in plain types, and as a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table

from deploy.run.fleet import ENOUGH
from deploy.run.outcome.reports import Report
from deploy.studies.endurance import flatness
from deploy.studies.endurance.judgement import Criterion, criteria_table, passed, plain
from deploy.studies.endurance.recovery import AGAIN, Recovery
from deploy.studies.endurance.samples import Samples
from deploy.studies.endurance.trial import Trial

_PACE = 0.99  # of the ticks that real time has


def result(
    trial: Trial,
    reports: list[Report],
    samples: Samples,
    step: float,
    recovery: Recovery | None = None,
    blows: Counter[str] | None = None,
) -> dict[str, Any]:
    """What came of a trial; `step` is the period of the clock, s."""
    recovery, blows = recovery or Recovery(), blows or Counter()
    ticks, wall = (sum(report[name] for report in reports) for name in ("ticks", "wall_time"))
    missed = sum(report["missed_commands"] for report in reports)
    verdicts = Counter(report["verdict"] for report in reports[:-1])
    last, lockstep = reports[-1], trial.options.lockstep
    criteria = [
        Criterion(
            "no command missed", f"{missed} of {ticks * trial.robots}",
            None if trial.disturbed else missed == 0 and ticks > 0,
        ),
        Criterion(
            "real time kept", f"{ticks / wall if wall else 0.0:.2f} of {1.0 / step:g} ticks a second",
            None if lockstep or trial.disturbed else ticks * step >= _PACE * wall > 0.0,
        ),
        Criterion("nothing touched", f"{(n := _sum(reports, 'collisions'))} collisions", n == 0),
        Criterion(
            "all arrived in every run that ended", f"{verdicts['arrived']} of {verdicts.total()}",
            verdicts["arrived"] == verdicts.total() and last["reason"] == ENOUGH,
        ),
        *_recovery(trial, recovery, blows),
        *_flatness(samples, trial.disturbed),
    ]  # fmt: skip
    return {
        "trial": "endurance",
        "robots": trial.robots,
        "minutes": trial.minutes,
        "mode": trial.options.mode,
        "transport": trial.options.transport,
        "secure": trial.options.secure is not None,
        "kill_every": trial.kill_every,
        "cut_every": trial.cut_every,
        "blows": dict(blows),
        "recoveries": [each._asdict() for each in recovery.recovered],
        "runs": len(reports),
        "verdicts": dict(verdicts),
        "failed": [f"{r['verdict']}: {r['reason']}" for r in reports[:-1] if r["verdict"] != "arrived"],
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


def _recovery(trial: Trial, recovery: Recovery, blows: Counter[str]) -> list[Criterion]:
    if not trial.disturbed:
        return []
    times = "; ".join(f"{what} {n} times" for what, n in sorted(blows.items())) or "nothing was done"
    worst = ", ".join(f"{seconds:.2f} s ({what})" for what, seconds in sorted(recovery.worst.items()))
    standing = ", ".join(f"{robot} ({what})" for robot, what in sorted(recovery.standing.items()))
    return [
        Criterion("disturbed as asked", times, bool(blows)),
        Criterion(
            f"moving again within {AGAIN:g} s",
            f"{recovery.count} robots, the slowest after {worst or '-'}{standing and f'; not: {standing}'}",
            recovery.count > 0 and not standing and max(recovery.worst.values()) <= AGAIN,
        ),
    ]


def _flatness(samples: Samples, disturbed: bool) -> list[Criterion]:
    trends = {name: _memory(series) for name, series in samples.of.items()}
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
        found = {
            name: flatness.steady(series[quantity], series["pid"], passing=disturbed)
            for name, series in samples.of.items()
        }
        growing = [name for name, flat in found.items() if flat is False]
        text = "too short to tell" if too_few else ", ".join(growing) or "in every process"
        listing.append(Criterion(words, text, None if too_few else not growing))
    return listing


def _memory(series: dict[str, Any]) -> flatness.Memory | None:
    return flatness.memory(series["time"], series["anonymous_mb"], series["pid"])


def _trend(series: dict[str, Any]) -> dict[str, Any]:
    trend = _memory(series)
    return {
        "lives": len(set(series["pid"])),
        **{name: _ends(series[name]) for name in ("anonymous_mb", "private_mb", "resident_mb")},
        "memory": None if trend is None else {**trend._asdict(), "flat": trend.flat},
        **{name: _ends(series[name]) for name in ("handles", "threads")},
    }


def _ends(values: Sequence[float]) -> dict[str, float]:
    return {"first": values[0], "most": max(values), "last": values[-1]}


def table(outcome: dict[str, Any]) -> RenderableType:
    """What a person wants to know."""
    listing = Table(box=None, padding=(0, 1), header_style="dim")
    listing.add_column("process", no_wrap=True)
    columns = ("lives", "MB", "rise", "allowed", "an hour", "private", "handles", "threads")
    for column in columns:
        listing.add_column(column, justify="right", no_wrap=True)
    for name, process in outcome["processes"].items():
        trend = process["memory"]
        cells = ["-"] * 3
        if trend is not None:
            slope = f"{trend['per_hour']:+.2f} ± {trend['error']:.2f}"
            cells = [f"{trend['rise']:+.2f}", f"{trend['allowed']:.2f}", slope]
        listing.add_row(
            name,
            str(process["lives"]),
            f"{process['anonymous_mb']['last']:.1f}",
            *cells,
            f"{process['private_mb']['last']:.1f}",
            *(f"{process[q]['first']:.0f} to {process[q]['last']:.0f}" for q in ("handles", "threads")),
        )
    criteria = [Criterion(**each) for each in outcome["criteria"]]
    return Group(listing, criteria_table(criteria))
