"""What is done to a fleet that endures, how its recovery is measured, and a short trial with both."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter

import pytest

from deploy.studies.endurance.disturbances import Blow, Disturbances
from deploy.studies.endurance.recovery import Recovery
from protocol.messages import Truth

STEP = 0.05  # s


def test_kills_and_cuts_come_when_they_are_due() -> None:
    disturbances = Disturbances(60.0, 300.0)
    found = [(t, blow) for t in range(3601) if (blow := disturbances.due(float(t), (3, 5, 9)))]
    kills = [(t, blow.kill) for t, blow in found if blow.kill]
    cuts = [(t, blow.cut) for t, blow in found if blow.cut]
    assert [t for t, _ in kills] == list(range(60, 3601, 60))
    assert [t for t, _ in cuts] == list(range(330, 3601, 300))
    names = Counter(name for _, name in kills)
    assert names.keys() == {"robot-3", "robot-5", "robot-9", "router", "world"}
    assert names["router"] == names["world"] == 6
    assert {robot for _, robot in cuts} <= {3, 5, 9}


def test_nobody_is_hit_who_is_not_under_way_and_nothing_unless_asked() -> None:
    assert Disturbances(60.0, 0.0).due(61.0, ()) is None
    assert Disturbances(0.0, 0.0).due(1e6, (1,)) is None
    late = Disturbances(60.0, 0.0)
    assert late.due(90.0, ()) is None
    assert late.due(91.0, (4,)) == Blow(kill="robot-4")
    assert late.due(92.0, (4,)) is None


def drive(recovery: Recovery, ticks: range, moving: range, x: float = 0.0) -> float:
    """Tell of robot 1, which moves from x in some ticks, and of robot 2, which always does."""
    for tick in ticks:
        x += 0.0025 if tick in moving else 0.0
        recovery.see(Truth(tick, (1, 2), ((x, 0.0), (0.001 * tick, 1.0)), 0.1, 0.5), tick * STEP)
    return x


def test_the_time_from_the_blow_to_the_next_movement() -> None:
    recovery = Recovery({1: (1.0, 0.0), 2: (0.0, 1.0)})
    x = drive(recovery, range(10), range(10))
    assert recovery.under_way == {1}  # 2 is at its goal
    recovery.hit("robot killed", [1], 10 * STEP)
    assert recovery.under_way == set()
    x = drive(recovery, range(10, 40), range(10, 12), x)  # what was commanded before the blow is no recovery
    assert recovery.standing == {1: "robot killed"}
    drive(recovery, range(40, 60), range(50, 60), x)
    assert recovery.standing == {}
    assert recovery.worst == {"robot killed": pytest.approx(40 * STEP)}
    assert [each.robot for each in recovery.recovered] == [1]
    assert recovery.count == 1


def test_a_jump_after_silence_or_into_another_run_is_no_movement() -> None:
    recovery = Recovery({1: (1.0, 0.0)})
    recovery.hit("router killed", [1], 0.0)
    recovery.see(Truth(1, (1,), ((0.0, 0.0),), 0.1, 0.5), 0.5)
    recovery.see(Truth(9, (1,), ((0.1, 0.0),), 0.1, 0.5), 1.5)
    recovery.see(Truth(0, (1,), ((0.2, 0.0),), 0.1, 0.5), 1.55)
    assert recovery.standing == {1: "router killed"}
    recovery.see(Truth(1, (1,), ((0.21, 0.0),), 0.1, 0.5), 1.6)
    assert recovery.worst == {"router killed": pytest.approx(1.6)}


@pytest.mark.process
@pytest.mark.timeout(90)
@pytest.mark.long(15)
def test_a_short_disturbed_trial() -> None:
    """Judged here is only what a busy machine cannot spoil."""
    call = [sys.executable, "-m", "deploy.cli", "endure", "--minutes", "0.1", "--robots", "3"]
    call += ["--kill-every", "2.5", "--cut-every", "2", "--json", "-"]
    done = subprocess.run(call, capture_output=True, text=True, timeout=80, check=False)
    outcome = json.loads(done.stdout)
    found = {each["what"]: each for each in outcome["criteria"]}
    assert found["disturbed as asked"]["holds"]
    assert outcome["blows"]["robot killed"] >= 2
    assert outcome["blows"]["link cut"] >= 1
    assert found["nothing touched"]["holds"]
    assert found["no command missed"]["holds"] is None
    assert outcome["recoveries"]
    assert any(process["lives"] > 1 for process in outcome["processes"].values())
    assert "cables" in outcome["processes"]
