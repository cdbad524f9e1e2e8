"""Sequences of left and right in which neither can be guessed from a long run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt


def balanced_sides(kinds: Sequence[int], generator: np.random.Generator) -> npt.NDArray[np.bool_]:
    """Return for each trial whether its target is on the left.

    Each kind of trial has as many on the left as on the right (one more or less where its number
    is odd), and no three trials in a row have theirs on the same side.

    Parameters
    ----------
    kinds : sequence of int, length n
        The kind of each trial.
    generator : numpy.random.Generator

    Returns
    -------
    ndarray of bool, shape (n,)

    Notes
    -----
    Two conditions of the form "these two differ" are enough. Trials are coupled with a neighbour,
    so that any three in a row hold a couple; and trials of one kind are coupled at random, which
    balances the kind. Both are matchings, and the union of two matchings has no odd cycle: sides
    that obey all couples exist whatever the kinds are, and each connected part is free to be
    mirrored.

    Examples
    --------
    >>> sides = balanced_sides([0] * 10, np.random.default_rng(0))
    >>> int(sides.sum()), "".join("RL"[int(side)] for side in sides)
    (5, 'LLRLRRLLRR')
    """
    count = len(kinds)
    first = int(generator.integers(2))
    couples = [(place, place + 1) for place in range(first, count - 1, 2)]
    for kind in sorted(set(kinds)):
        places = generator.permutation([place for place in range(count) if kinds[place] == kind])
        couples += [(int(a), int(b)) for a, b in zip(places[::2], places[1::2], strict=False)]
    return _sides_that_differ(couples, count, generator)


def _sides_that_differ(
    couples: list[tuple[int, int]], count: int, generator: np.random.Generator
) -> npt.NDArray[np.bool_]:
    """Return sides in which the two of each couple differ; the couples have no odd cycle."""
    beside: list[list[int]] = [[] for _ in range(count)]
    for a, b in couples:
        beside[a].append(b)
        beside[b].append(a)
    sides: dict[int, bool] = {}
    for start in range(count):
        if start in sides:
            continue
        sides[start] = bool(generator.integers(2))
        waiting = [start]
        while waiting:
            here = waiting.pop()
            for other in beside[here]:
                if other not in sides:
                    sides[other] = not sides[here]
                    waiting.append(other)
    return np.array([sides[place] for place in range(count)], bool)


def longest_run(sides: Sequence[object]) -> int:
    """Return how many equal sides in a row there are at most.

    Parameters
    ----------
    sides : sequence

    Returns
    -------
    int
        0 if there are none.

    Examples
    --------
    >>> longest_run(["left", "left", "right"])
    2
    """
    longest = run = 0
    for place, side in enumerate(sides):
        run = run + 1 if place and side == sides[place - 1] else 1
        longest = max(longest, run)
    return longest
