"""Whom a later life has to agree with, by the first roster that it hears."""

from __future__ import annotations

import pytest

from agents.lines.separating_lines import SeparatingLines
from protocol.messages import Member


@pytest.mark.parametrize("robot", [1, 5])
def test_a_life_stands_until_it_has_a_line_with_a_robot_that_only_the_roster_names(robot: int) -> None:
    added = Member(3, 1, "live", 0.05, None, 0.0, 0)

    lines = SeparatingLines(robot, 2, {robot: 0.05}, speed=0.1, period=0.05, members={3: added})

    assert not lines.ready
