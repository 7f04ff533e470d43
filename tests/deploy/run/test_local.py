"""What a run in this process does to the garbage collector."""

import gc

import pytest

from deploy.run.local import seldom_collecting


def test_thresholds_are_those_from_before_whatever_happens() -> None:
    before = gc.get_threshold()
    with seldom_collecting():
        assert gc.get_threshold() != before
        with seldom_collecting():
            pass
    assert gc.get_threshold() == before
    with pytest.raises(ZeroDivisionError), seldom_collecting():
        raise ZeroDivisionError
    assert gc.get_threshold() == before
