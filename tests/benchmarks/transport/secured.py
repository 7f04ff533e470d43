"""What certificates and rules cost: the same run over plain TCP, over mutual TLS, and with access rules.

python -m tests.benchmarks.transport.secured --robots 6 16
"""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from deploy.library.load import load
from deploy.processes import table
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from deploy.security.keystore import create
from deploy.security.membership import KeyRing
from deploy.security.roster import KeyRoster
from protocol.scenario.model import Scenario
from tests.benchmarks.transport.bare import Rate

RUN = "measured"
VARIANTS = ("plain", "tls", "tls and rules")


def rate(scenario: Scenario, variant: str, keys: Path) -> Rate:
    """One lock-step run of `scenario`."""
    secure = None if variant == "plain" else keys
    with _router(variant, secure) as (router, endpoint):
        with Fleet(scenario, RunOptions(router=endpoint, run=RUN, secure=secure)) as fleet:
            report = fleet.execute()
            processes = fleet.processes()
        router.stop()
        cpu = sum(process["cpu_s"] for process in processes) + sum(u.cpu_s for u in router.usage())
    return Rate(report["ticks"] / report["wall_time"], 1000.0 * cpu / report["ticks"])


@contextmanager
def _router(variant: str, secure: Path | None) -> Iterator[tuple[Supervisor, str]]:
    connection = KeyRing(secure).router()
    if variant == "tls":
        connection = replace(connection, access=None)
    with Supervisor() as supervisor:
        supervisor.start([table.router(connection)])
        yield supervisor, supervisor.report("router", 20.0)


def main() -> None:
    """Print medians, with the variants taking turns so that a busy machine treats them alike."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, nargs="+", default=[6, 16])
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    print(f"{'robots':>6}  {'variant':<14}{'ticks/s':>9}{'cpu ms/tick':>13}{'of plain':>10}")
    for robots in options.robots:
        scenario = load(f"swap-{robots}", ["control.speed=0.02", "time.limit=30"])
        with TemporaryDirectory() as folder:
            create(Path(folder) / "keys", KeyRoster(RUN, scenario.ids))
            rates: dict[str, list[Rate]] = {variant: [] for variant in VARIANTS}
            for _ in range(options.repeat):
                for variant in VARIANTS:
                    rates[variant].append(rate(scenario, variant, Path(folder) / "keys"))
        plain = median(each.cpu_ms for each in rates["plain"])
        for variant, each in rates.items():
            frequency, cpu = median(r.ticks_per_second for r in each), median(r.cpu_ms for r in each)
            print(f"{robots:>6}  {variant:<14}{frequency:>9.0f}{cpu:>13.2f}{cpu / plain:>10.2f}", flush=True)


if __name__ == "__main__":
    main()
