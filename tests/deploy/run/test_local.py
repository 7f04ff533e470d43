"""What a run in this process costs the garbage collector, and that no garbage piles up over many."""

import gc
import weakref

import pytest

from deploy.run.local import seldom_collecting


class Ring:
    """Garbage once it is unreachable: it refers to itself, and to so many others of its kind."""

    def __init__(self, more: int = 0) -> None:
        self.parts = [self, *(Ring() for _ in range(more))]


def run() -> None:
    with seldom_collecting():
        pass


def test_what_a_run_leaves_is_gone_when_the_next_begins() -> None:
    with seldom_collecting():
        left = weakref.ref(Ring())
    assert left() is not None
    run()
    assert left() is None


def test_thresholds_are_those_from_before_whatever_happens() -> None:
    before = gc.get_threshold()
    with seldom_collecting():
        assert gc.get_threshold() != before
    assert gc.get_threshold() == before
    with pytest.raises(ZeroDivisionError), seldom_collecting():
        raise ZeroDivisionError
    assert gc.get_threshold() == before
    assert gc.get_freeze_count() == 0
