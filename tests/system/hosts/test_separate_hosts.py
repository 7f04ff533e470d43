"""Hosts, each with a router and robots: a cable that is pulled for seconds."""

from pathlib import Path

import pytest

from deploy.library.load import load
from tests.system.hosts.testbed.network import Hosts, needs_hosts

SCENARIO = load("figure-1", ["control.speed=0.03", "time.limit=90"], 3)
THREE, SIX = {1: 1, 2: 1, 3: 2, 4: 2, 5: 3, 6: 3}, {robot: robot for robot in range(1, 7)}  # robot -> host


@pytest.mark.campaign
@pytest.mark.timeout(240)
@needs_hosts
@pytest.mark.parametrize(("homes", "host"), [(THREE, 3), (SIX, 1)])  # the world's loses all its links
def test_a_cable_pulled_for_seconds(homes: dict[int, int], host: int, tmp_path: Path) -> None:
    cut, mended = SCENARIO.ticks(3.0), SCENARIO.ticks(6.5)
    truth: dict[int, dict[str, list[float]]] = {}
    report, silent, back = {}, None, None
    with Hosts(max(homes.values()), tmp_path / "log") as hosts:
        for told in hosts.fleet(SCENARIO, homes, lockstep=False):
            if "report" in told:
                report = told["report"]
                continue
            truth[told["tick"]] = told["positions"]
            if told["tick"] >= cut and silent is None:  # an observer may miss a tick
                hosts.cut(host)
                silent = told["tick"] + SCENARIO.ticks(1.0)  # by then the world hears nothing
            elif told["tick"] >= mended and back is None:
                hosts.mend(host)
                back = told["tick"]
    during = [positions for tick, positions in truth.items() if silent <= tick <= back]
    assert len(during) > SCENARIO.ticks(1.5)
    moved = {robot: any(each[robot] != during[0][robot] for each in during) for robot in during[0]}
    assert moved == {str(robot): (home == host) == (host == 1) for robot, home in homes.items()}
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["min_clearance"] > 0.0
