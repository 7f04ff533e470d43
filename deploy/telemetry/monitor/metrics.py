"""Metrics of a fleet for Prometheus, in OpenMetrics form, over HTTP.

Dashboards rely on their names and meanings; `docs/guides/dashboard.json` is an example for Grafana.
"""

from __future__ import annotations

from collections.abc import Iterator

from deploy.telemetry.live import FleetView
from deploy.telemetry.monitor.snapshot import Source
from protocol.process.installation import missing_library

try:
    from prometheus_client import CollectorRegistry, start_http_server
    from prometheus_client.metrics_core import (
        CounterMetricFamily,
        GaugeMetricFamily,
        InfoMetricFamily,
        Metric,
        StateSetMetricFamily,
    )
    from prometheus_client.registry import Collector
except ModuleNotFoundError as error:
    raise missing_library("serving metrics", "prometheus-client", "metrics") from error

PHASES = ("searching", "gathering", "running", "paused", "halted", "ended", "lost")
HOST = "127.0.0.1"


class FleetCollector(Collector):
    """Collects the metrics of one run at each request."""

    def __init__(self, source: Source) -> None:
        self._source = source

    def collect(self) -> Iterator[Metric]:
        yield from self._source.change(lambda view, now: [*_fleet(view), *_robots(view, now)])


def _fleet(view: FleetView) -> Iterator[Metric]:
    scenario = "" if view.scenario is None else view.scenario.name
    yield InfoMetricFamily(
        "disknav_run", "The run.", {"run": view.run, "scenario": scenario, "verdict": view.verdict}
    )
    phases = {phase: view.phase == phase for phase in PHASES}
    yield StateSetMetricFamily("disknav_phase", "Phase of the run.", phases)
    if view.scenario is None:
        return
    yield CounterMetricFamily("disknav_ticks", "Ticks of the present scenario.", view.tick)
    yield CounterMetricFamily("disknav_missed_commands", "Commands that did not arrive in time.", view.missed)
    if view.recent:
        last = view.recent[-1].clearance
        yield GaugeMetricFamily(
            "disknav_clearance_meters", "Gap in the last tick; negative is overlap.", last
        )
    if view.smallest is not None:
        yield GaugeMetricFamily("disknav_smallest_clearance_meters", "Smallest gap so far.", view.smallest)


def _robots(view: FleetView, now: float) -> Iterator[Metric]:
    rejected = CounterMetricFamily(
        "disknav_rejected_messages", "Messages that were dropped.", labels=["receiver", "reason"]
    )
    restarts = CounterMetricFamily("disknav_restarts", "Lives after the first.", labels=["robot"])
    present = GaugeMetricFamily("disknav_present", "Whether its liveliness token exists.", labels=["robot"])
    fenced = GaugeMetricFamily(
        "disknav_fenced", "Whether its disk is static, without a life.", labels=["robot"]
    )
    lines = GaugeMetricFamily("disknav_lines", "Separating lines that it obeys.", labels=["robot"])
    age = GaugeMetricFamily("disknav_state_age_seconds", "Age of its newest State.", labels=["robot"])
    distance = GaugeMetricFamily("disknav_goal_distance_meters", "Distance to its goal.", labels=["robot"])
    for reason, count in view.rejected.items():
        rejected.add_metric(["world", reason], count)
    for robot, seen in view.robots.items():
        name = [f"robot-{robot}"]
        present.add_metric(name, float(seen.alive is True))
        fenced.add_metric(name, float(seen.fenced))
        restarts.add_metric(name, seen.restarts)
        distance.add_metric(name, seen.distance)
        if (since := seen.age(now)) is not None:
            age.add_metric(name, since)
        if seen.health is not None:
            lines.add_metric(name, len(seen.health.lines))
            for reason, count in seen.health.rejected.items():
                rejected.add_metric([*name, reason], count)
    yield from (rejected, restarts, present, fenced, lines, age, distance)


def export(source: Source, where: str) -> str:
    """Serve the metrics at `[ADDRESS:]PORT` from a thread, as long as this process lives.

    Returns: the URL, such as `http://127.0.0.1:9464/metrics`. Raises OSError if the address is taken.
    """
    address, _, port = where.rpartition(":")
    host = address.strip("[]") or HOST
    registry = CollectorRegistry(auto_describe=False)
    registry.register(FleetCollector(source))
    server, _ = start_http_server(int(port), host, registry)
    return f"http://{address or HOST}:{server.server_port}/metrics"
