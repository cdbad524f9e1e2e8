"""How smooth the cost of a colour has to be: leave one object out, and see how likely it is.

The weight that the authors found is not published, so it is found here. On the ten training objects
of MIT-Berkeley the mean held-out cost is 1.667, 1.319, 1.200 and 1.247 for the `CANDIDATES`
(``relightlab sirfs train --search``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from evaluation.sirfs.absolute_color import (
    color_whitening,
    fit_color_absolute,
    mean_cost,
    trilinear_splat,
)
from shading_model.arrays import Float
from shading_model.errors import RelightlabError

CANDIDATES = (2.0**-10, 2.0**-11, 2.0**-12, 2.0**-13)
KNOTS = 52
"""Along an axis; a grid of 102 takes sixteen times as long."""


def held_out_costs(
    objects: Sequence[Float],
    candidates: Sequence[float] = CANDIDATES,
    knots: int = KNOTS,
    report: Callable[[int, int, str], None] = lambda *_: None,
) -> Float:
    """Return how unlikely each object's colours are to what the others taught, by smoothness.

    Parameters
    ----------
    objects : sequence of (n, 3) arrays
        Log albedos.
    candidates : sequence of float
        Weights of the bending.
    knots : int
        27, 52 or 102.
    report : callable
        Called with how many objects are done, of how many, and which was last.

    Returns
    -------
    (len(candidates), len(objects)) array
        Mean minus log density, per unit volume of log albedo.

    Raises
    ------
    RelightlabError
        If there are fewer than two objects, or one has NaN.

    Examples
    --------
    >>> generator = np.random.default_rng(0)
    >>> objects = [generator.normal(-1.0, 0.7, (500, 3)) for _ in range(2)]
    >>> held_out_costs(objects, (2.0**-9,), 27).shape
    (1, 2)
    """
    if len(objects) < 2:
        raise RelightlabError(f"expected at least two objects to leave one out, got {len(objects)}")
    columns = []
    for left_out, held_out in enumerate(objects):
        others = np.concatenate([one for k, one in enumerate(objects) if k != left_out])
        columns.append(_costs_of(held_out, others, candidates, knots))
        report(left_out + 1, len(objects), f"object {left_out + 1}")
    return np.array(columns).T


def _costs_of(
    held_out: Float, others: Float, candidates: Sequence[float], knots: int
) -> list[float]:
    whitening = color_whitening(others)
    whitened = held_out @ whitening
    # A density of whitened colours becomes one of log albedos by the volume that W spans.
    volume = float(np.log(np.linalg.det(whitening)))
    fits = (fit_color_absolute(others @ whitening, weight, knots) for weight in candidates)
    return [mean_cost(fit, trilinear_splat(whitened, len(fit))) - volume for fit in fits]
