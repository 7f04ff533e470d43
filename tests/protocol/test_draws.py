"""Draws by counter: a key determines its numbers, whatever else was drawn."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from protocol.draws import Purpose, generator

keys = st.tuples(
    st.integers(0, 2**63 - 1), st.sampled_from(Purpose), st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1)
)


@given(st.lists(keys, min_size=2, max_size=8, unique=True))
def test_different_keys_give_different_numbers(drawn: list[tuple[int, Purpose, int, int]]) -> None:
    numbers = {tuple(generator(*key).integers(0, 2**63, 4).tolist()) for key in drawn}
    assert len(numbers) == len(drawn)


def test_neighbouring_ticks_do_not_overlap() -> None:
    """A tick that draws much must not run into the numbers of the next."""
    long = generator(1, Purpose.LINK, 3, 10).integers(0, 2**63, 100_000)
    after = generator(1, Purpose.LINK, 3, 11).integers(0, 2**63, 4)
    assert not np.isin(after, long).any()


def test_draws_are_fixed_for_ever() -> None:
    """The numbers themselves are a promise: recorded seeds must mean the same tomorrow."""
    drawn = generator(7, Purpose.SENSING, robot=2, tick=5).integers(0, 1000, 5).tolist()
    assert drawn == [491, 919, 984, 273, 547]
