"""Three hosts, each with a router and two robots: a cable that is pulled for seconds."""

from pathlib import Path

import pytest

from deploy.library.load import load
from tests.system.hosts.testbed.network import Hosts, needs_hosts

SCENARIO = load("figure-1", ["control.speed=0.03", "time.limit=90"], 3)
HOMES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 3, 6: 3}  # robot -> host


@pytest.mark.campaign
@pytest.mark.timeout(240)
@needs_hosts
def test_a_cable_pulled_for_seconds(tmp_path: Path) -> None:
    cut, mended = SCENARIO.ticks(3.0), SCENARIO.ticks(6.5)
    truth: dict[int, dict[str, list[float]]] = {}
    report, silent, back = {}, None, None
    with Hosts(3, tmp_path / "log") as hosts:
        for told in hosts.fleet(SCENARIO, HOMES, lockstep=False):
            if "report" in told:
                report = told["report"]
                continue
            truth[told["tick"]] = told["positions"]
            if told["tick"] >= cut and silent is None:  # an observer may miss a tick
                hosts.cut(3)
                silent = told["tick"] + SCENARIO.ticks(1.0)  # by then the world hears nothing
            elif told["tick"] >= mended and back is None:
                hosts.mend(3)
                back = told["tick"]
    during = [positions for tick, positions in truth.items() if silent <= tick <= back]
    assert len(during) > SCENARIO.ticks(1.5)
    moved = {robot: any(each[robot] != during[0][robot] for each in during) for robot in during[0]}
    assert moved == {"1": True, "2": True, "3": True, "4": True, "5": False, "6": False}
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["min_clearance"] > 0.0
