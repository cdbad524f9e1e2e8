"""Sequences of sides: balanced in every kind, without long runs, and random."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from studies.side_sequences import balanced_sides, longest_run


@settings(deadline=None)
@given(st.lists(st.integers(0, 3), max_size=60), st.integers(0, 2**32))
def test_any_kinds_in_any_order_balance(kinds: list[int], seed: int) -> None:
    """Every kind is balanced to within one trial, and no side comes three times in a row."""
    sides = balanced_sides(kinds, np.random.default_rng(seed))
    assert sides.shape == (len(kinds),)
    assert longest_run(sides.tolist()) <= 2
    for kind in set(kinds):
        own = sides[np.array(kinds) == kind]
        assert abs(int(own.sum()) - int((~own).sum())) <= 1


def test_each_place_is_left_half_of_the_time() -> None:
    """Over many draws no place and no step between neighbours can be guessed."""
    generator = np.random.default_rng(1)
    sides = np.array([balanced_sides([0] * 10, generator) for _ in range(2000)])
    np.testing.assert_allclose(sides.mean(axis=0), 0.5, atol=0.05)
    alternates = (sides[:, 1:] != sides[:, :-1]).mean()
    assert 0.5 < alternates < 0.8  # runs of three are barred, so a change is likelier than not
    assert len(np.unique(sides, axis=0)) > 60


def test_runs_are_counted() -> None:
    """The longest run is that of equal neighbours, none in an empty sequence."""
    assert [longest_run(list(text)) for text in ("", "L", "LR", "LLRRRL")] == [0, 1, 1, 3]
