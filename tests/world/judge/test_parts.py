"""A tick of several parts is judged in each of them."""

from __future__ import annotations

import pytest

from tests.world.driving import two
from world.judge.goals import Goals
from world.judge.record import Record


def test_a_touch_within_a_tick_is_found_when_and_where_it_was() -> None:
    setting = two()
    record = Record(setting, Goals(setting), [(-0.1, 0.1), (-0.1, -0.1)], parts=2)
    record.add([(-0.1, 0.1), (-0.1, -0.1)], [((-0.1, 0.01), (-0.1, -0.01))])
    record.add([(-0.1, 0.1), (-0.1, -0.1)], [((-0.1, 0.1), (-0.1, -0.1))])
    (contact,) = record.contacts.all
    assert record.clearance == pytest.approx(-0.06)
    assert contact.deepest == pytest.approx(-0.06)
    assert 0.25 < contact.begin < 0.5 < contact.end < 0.75
    assert record.truth.tick == 2
    assert [truth.tick for truth in record.news()] == [0, 1, 2]
    assert record.truth.clearance == pytest.approx(0.26 - 0.1 * 2.0**0.5)  # to the boundary
