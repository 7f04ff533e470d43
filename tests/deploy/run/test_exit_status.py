"""What the exit status says of a result."""

from __future__ import annotations

import pytest

from deploy.run.outcome.result import served_status


@pytest.mark.parametrize(
    ("verdict", "collisions", "status"),
    [("interrupted", 0, 0), ("aborted", 0, 3), ("collision", 1, 1)],
)
def test_a_fleet_that_is_to_stay_up_ends_well_only_if_it_is_stopped(
    verdict: str, collisions: int, status: int
) -> None:
    assert served_status({"verdict": verdict, "collisions": collisions}) == status
