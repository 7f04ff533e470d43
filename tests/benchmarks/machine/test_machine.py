"""What a robot and its base take of a machine is measured. Nothing is timed here."""

from __future__ import annotations

import pytest

from tests.benchmarks.machine import cores, physics


def test_all_cores_are_measured() -> None:
    found = cores.costs(3, repeat=1, number=2)
    assert list(found) == ["slice", "filter", "codec", "robot", "world"]
    assert all(cost.core > 0.0 and cost.floor > 0.0 for cost in found.values())


@pytest.mark.process
def test_fleets_in_a_physics_engine_are_measured() -> None:
    pytest.importorskip("mujoco")
    found = physics.swap(2, "wheels in MuJoCo", limit=1.0)
    assert found.time == pytest.approx(1.0)
    assert min(found[:-1]) > 0.0
    floor = found._replace(time=0.5, path=2.0 * found.path)
    words = physics.line(6, "wheels in MuJoCo", found._replace(factor=12.3), floor).split()
    assert words[:6] == ["6", "wheels", "in", "MuJoCo", "12.3", "10"]
    assert [words[10], words[12]] == ["(2.00)", "(0.50)"]
