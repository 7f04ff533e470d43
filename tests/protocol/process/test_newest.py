"""What is kept of the newest result, and for whom."""

from __future__ import annotations

from protocol.process.newest import keeps_newest


def test_whoever_comes_with_the_same_or_an_equal_thing_gets_the_same_result() -> None:
    made = []

    @keeps_newest
    def make(told: list[int]) -> list[int]:
        made.append(told)
        return [*told]

    first, equal, other = [1], [1], [2]
    result = make(first)
    assert make(first) is result
    assert make(equal) is result
    assert make(other) == [2]
    assert make(first) == result
    assert make(first) is not result
    assert made == [[1], [2], [1]]
