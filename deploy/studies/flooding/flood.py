"""A lock-step fleet with and without a flood of garbage, in turns: what it costs, and what comes of it."""

from __future__ import annotations

import time
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, Literal

from rich.console import Group, RenderableType
from rich.table import Table

from deploy.run.fleet import ENOUGH, Fleet
from deploy.run.options import RunOptions, fresh_run_name
from deploy.run.outcome.reports import Report
from deploy.security.membership import Membership
from deploy.security.roster import Roster, robot_role
from deploy.studies.endurance.judgement import Criterion, criteria_table, passed, plain
from deploy.studies.endurance.workload import workload
from deploy.studies.flooding.flooder import Flooded, Flooder
from deploy.studies.flooding.intervals import Intervals
from protocol.bus.connection import Connection
from protocol.messages import Clock

Flooding = Literal["monitor", "operator", "robot"]
SLOWER = 0.20  # of the rate without the flood
_RATE = 0.95  # of the messages asked for
_SPEED = 0.02  # m/s: thousands of ticks a run


@dataclass(frozen=True)
class Plan:
    """What is asked for. `secure`: access rules, and the flooder has a certificate."""

    rate: float  # messages per second
    robots: int
    rounds: int  # of a calm and a flooded stretch each
    seconds: float  # a stretch
    secure: bool
    role: Flooding = (
        "monitor"  # whose certificate the flooder has, if there are any; `robot` is one of the fleet
    )


def flood(plan: Plan, tell: Callable[[float], None]) -> dict[str, Any]:
    """Measure and judge; the result in plain types.

    Raises:
        UsageError: there is no library for certificates.
        ProcessError, BusError: a process did not start, or was lost.
    """
    with TemporaryDirectory(prefix="disknav-") as folder:
        options = _options(plan, Path(folder) / "keys")
        intervals, floods, reports = _measure(plan, options, tell)
    return result(plan, intervals.rates, floods, reports)


def _options(plan: Plan, keys: Path) -> RunOptions:
    options = RunOptions(run=fresh_run_name())
    if not plan.secure:
        return options
    from deploy.security.keystore import create

    create(keys, Roster(options.run, workload(plan.robots, speed=_SPEED)[0].ids))
    return RunOptions(run=options.run, secure=keys)


def _measure(
    plan: Plan, options: RunOptions, tell: Callable[[float], None]
) -> tuple[Intervals, list[Flooded], list[Report]]:
    scenarios = workload(plan.robots, speed=_SPEED)
    intervals, floods = Intervals(plan.seconds), list[Flooded]()
    flooder: Flooder | None = None

    def watch(clock: Clock) -> None:
        if (
            flooder is None
            or over()
            or not intervals.on_clock(time.monotonic(), clock.run_number, clock.tick)
        ):
            return
        done = len(intervals.rates)
        if done % 2:
            flooder.begin()
        else:
            floods.append(flooder.end())
        tell(done / (2 * plan.rounds))

    def over() -> bool:
        return len(intervals.rates) == 2 * plan.rounds

    with Fleet(scenarios, options, watch=watch) as fleet:
        connection = _connection(plan, options, fleet.topology.observer(), scenarios[0].ids)
        with Flooder(connection, options.run, scenarios[0].ids, plan.rate) as flooder:
            flooder.connected()
            reports = fleet.execute(over)
        fleet.processes()
    return intervals, floods, reports


def _connection(plan: Plan, options: RunOptions, observer: Connection, robots: Sequence[int]) -> Connection:
    if plan.role == "monitor" or not plan.secure:
        return observer
    role = robot_role(robots[0]) if plan.role == "robot" else plan.role
    return Membership(options.secure).client(role, observer.connect)


def result(plan: Plan, rates: list[float], floods: list[Flooded], reports: list[Report]) -> dict[str, Any]:
    """What came of it: `rates` of calm and flooded stretches in turns."""
    calm, flooded = rates[0::2], rates[1::2]
    ratios = [wet / dry for dry, wet in zip(calm, flooded, strict=False) if dry]
    slower = 1.0 - median(ratios) if ratios else None
    sent, seconds = sum(each.sent for each in floods), sum(each.seconds for each in floods)
    rejected: Counter[str] = Counter()
    for report in reports:
        rejected.update(report["messages"]["rejected"])
    paths: defaultdict[int, set[str]] = defaultdict(set)
    for number, report in enumerate(reports[:-1]):
        paths[number % 2].add(report["trajectory_sha256"])
    touched = sum(report["collisions"] for report in reports)
    rate = sent / seconds if seconds else 0.0
    criteria = [
        Criterion("flooded as asked", f"{rate:.0f} messages a second", rate >= _RATE * plan.rate),
        Criterion(
            f"at most {SLOWER:.0%} slower",
            "not measured" if slower is None else f"{slower:.1%} slower, median of {len(ratios)} rounds",
            None if not plan.secure or plan.role == "robot" else slower is not None and slower <= SLOWER,
        ),
        Criterion("nothing touched", f"{touched} collisions", touched == 0),
        Criterion(
            "the same trajectories", f"{len(reports) - 1} runs there and back",
            all(len(found) == 1 for found in paths.values()) and reports[-1]["reason"] == ENOUGH,
        ),
        _reached(plan, rejected),
    ]  # fmt: skip
    return {
        "trial": "flood",
        "secure": plan.secure,
        "role": plan.role if plan.secure else None,
        "robots": plan.robots,
        "rate": rate,
        "sent": sent,
        "ticks_per_second": {"calm": calm, "flooded": flooded},
        "slower": slower,
        "rejected": dict(rejected),
        "ended": reports[-1]["reason"],
        "passed": passed(criteria),
        "criteria": plain(criteria),
    }


def _reached(plan: Plan, rejected: Counter[str]) -> Criterion:
    """Past the rules gets what a robot may say, and nothing else; receivers refuse that, and count."""
    if plan.secure and plan.role != "robot":
        return Criterion("nothing got past the router", f"{rejected.total()} rejected", not rejected)
    text = ", ".join(f"{count} {reason}" for reason, count in sorted(rejected.items()))
    return Criterion("receivers counted what they rejected", text or "nothing", bool(rejected))


def table(outcome: dict[str, Any]) -> RenderableType:
    """What a person wants to know."""
    listing = Table(box=None, padding=(0, 1), header_style="dim")
    for column in ("round", "calm, ticks/s", "flooded, ticks/s"):
        listing.add_column(column, justify="right")
    rates = outcome["ticks_per_second"]
    for number, pair in enumerate(zip(rates["calm"], rates["flooded"], strict=False), 1):
        listing.add_row(str(number), *(f"{each:.0f}" for each in pair))
    criteria = [Criterion(**each) for each in outcome["criteria"]]
    return Group(listing, criteria_table(criteria))
