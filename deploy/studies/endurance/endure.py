"""One trial of endurance: a fleet that never rests, what is done to it, and what its processes hold on to."""

from __future__ import annotations

import os
import signal
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table

from deploy.processes.table import ROUTER, WORLD
from deploy.run.fleet import ENOUGH, Fleet
from deploy.run.interruption import undisturbed
from deploy.run.options import RunOptions
from deploy.run.outcome.reports import Report
from deploy.run.topology import Routed, Topology
from deploy.studies.endurance import flatness
from deploy.studies.endurance.cables import Cables
from deploy.studies.endurance.disturbances import CUT, Blow, Disturbances
from deploy.studies.endurance.judgement import Criterion, criteria_table, passed, plain
from deploy.studies.endurance.recovery import Recovery
from deploy.studies.endurance.samples import Samples
from deploy.studies.endurance.workload import workload
from protocol.bus.events import Sample
from protocol.bus.zenoh import ZenohBus
from protocol.errors import MessageError
from protocol.keys import world_key
from protocol.messages import Clock, Truth
from protocol.scenario.model import Scenario
from protocol.wire.codec import decode

LAUNCHER = "launcher"
CABLES = "cables"
AGAIN = 5.0  # s after which a robot that was started again, or is reached again, moves
_SAMPLES = 240  # a trial, at least 0.25 s and at most 30 s apart
_SPEED = 0.05  # m/s; half a minute a run
_PACE = 0.99  # of the ticks that real time has
_KEPT = ("run_number", "verdict", "reason", "ticks", "wall_time", "missed_commands", "collisions")


@dataclass(frozen=True)
class Trial:
    """What is asked of a fleet."""

    robots: int
    minutes: float
    options: RunOptions
    kill_every: float = 0.0  # s; 0: nobody is killed. Needs processes that are started again.
    cut_every: float = 0.0  # s; 0: no link is cut. Needs a router.

    @property
    def disturbed(self) -> bool:
        """Whether anything is done to the fleet."""
        return self.kill_every > 0.0 or self.cut_every > 0.0


def endure(trial: Trial, tell: Callable[[float], None]) -> dict[str, Any]:
    """Keep the fleet moving for its minutes, and judge; the result in plain types.

    Raises:
        ProcessError, BusError: the fleet could not be started.
    """
    seconds = 60.0 * trial.minutes
    scenarios = workload(trial.robots, speed=_SPEED, seconds=None if trial.options.lockstep else seconds)
    samples = Samples(min(30.0, max(0.25, seconds / _SAMPLES)))
    with ExitStack() as stack:
        observation = _Observation(trial, scenarios, stack)
        with Fleet(
            scenarios, trial.options, watch=observation.watch, digest=_digest, lead=observation.lead
        ) as fleet:
            observation.attach(fleet)

            def enough() -> bool:
                samples.take(observation.pids())
                elapsed = observation.follow()
                tell(elapsed / seconds)
                late = elapsed >= seconds + CUT + AGAIN  # for who was hit last to move again
                return elapsed >= seconds and (late or not observation.recovery.standing)

            reports = fleet.execute(enough)
            fleet.processes()
        with undisturbed():
            stack.close()
    return result(trial, reports, samples, scenarios[0].time.step, observation.recovery, observation.blows)


def _digest(report: Report) -> Report:
    """What is kept of each run: hundreds of whole reports would look like a leak."""
    return {name: report[name] for name in _KEPT}


class _Observation:
    """Watches a fleet, and does to it what is due.

    Attributes:
        blows: how many of each kind there were.
    """

    def __init__(self, trial: Trial, scenarios: Sequence[Scenario], stack: ExitStack) -> None:
        self.recovery = Recovery()
        self.blows: Counter[str] = Counter()
        self._trial, self._scenarios, self._stack = trial, scenarios, stack
        self._disturbances = Disturbances(trial.kill_every, trial.cut_every)
        self._cables: Cables | None = None
        self._bus: ZenohBus | None = None
        self._fleet: Fleet | None = None
        self._began: float | None = None  # s, monotonic: with the first tick

    def lead(self, topology: Topology) -> Topology:
        """Every robot at a cable, if any is to be pulled."""
        if not self._trial.cut_every or not isinstance(topology, Routed):
            return topology
        cables = Cables(topology, self._scenarios[0].ids, self._trial.options.run)
        self._cables = self._stack.enter_context(cables)
        return cables.topology()

    def attach(self, fleet: Fleet) -> None:
        """Look at where robots are, if that is needed."""
        self._fleet = fleet
        if self._trial.disturbed:
            self._bus = ZenohBus(fleet.topology.observer())
            self._stack.callback(self._bus.close)
            self._bus.subscribe(world_key(self._trial.options.run, "truth"))

    def watch(self, clock: Clock) -> None:
        """What the world's clock says."""
        if self._began is None or (clock.tick == 0 and clock.run_number == 0):
            self._began = time.monotonic()
        robots = self._scenarios[min(clock.run_number, len(self._scenarios) - 1)].robots
        self.recovery.goals = {robot.id: robot.goal for robot in robots}

    def pids(self) -> dict[str, int]:
        """Of all processes that take part."""
        assert self._fleet is not None
        cables = {} if self._cables is None else {CABLES: self._cables.pid}
        return {**self._fleet.pids(), **cables, LAUNCHER: os.getpid()}

    def follow(self) -> float:
        """Hear where robots are, do what is due; returns the s since the first tick."""
        now = time.monotonic()
        while self._bus is not None and (event := self._bus.receive(0.0)) is not None:
            if isinstance(event, Sample):
                self._see(event, now)
        if self._began is None:
            return 0.0
        elapsed = now - self._began
        if elapsed < 60.0 * self._trial.minutes:
            blow = self._disturbances.due(elapsed, self.recovery.under_way)
            if blow is not None:
                self._strike(blow, now)
        return elapsed

    def _see(self, sample: Sample, now: float) -> None:
        try:
            truth = decode(sample.key, sample.payload)
        except MessageError:
            return
        if isinstance(truth, Truth):
            self.recovery.see(truth, now)

    def _strike(self, blow: Blow, now: float) -> None:
        if blow.cut is not None and self._cables is not None:
            self._cables.pull(blow.cut, CUT)
            self.recovery.hit("link cut", [blow.cut], now + CUT)
            self.blows["link cut"] += 1
        elif blow.kill is not None and self._fleet is not None:
            self._fleet.signal(blow.kill, signal.SIGKILL)
            vital = blow.kill in (ROUTER, WORLD)
            what = f"{blow.kill if vital else 'robot'} killed"
            robots = self.recovery.under_way if vital else [int(blow.kill.rpartition("-")[-1])]
            self.recovery.hit(what, robots, now)
            self.blows[what] += 1


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
