"""What every model asks of its answers and columns before it is fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shading_model.arrays import Float
from shading_model.errors import RelightlabError

LARGEST_LOG_ODDS = 15.0
"""A fixed part beyond this, in answers without exception, has no finite estimate."""


def check_answers(answers: Float) -> None:
    """Refuse outcomes that are not answers between 0 and 1.

    Parameters
    ----------
    answers : (n,) array

    Raises
    ------
    RelightlabError
        If there is none, or one is NaN or out of range.
    """
    wrong = ~((answers >= 0) & (answers <= 1))
    if not answers.size or wrong.any():
        came = f"{answers[wrong][0]:g}" if wrong.any() else "no answers"
        raise RelightlabError(f"expected outcomes from 0 to 1, got {came}")


def check_columns(matrix: Float, terms: Sequence[str]) -> None:
    """Refuse columns that are not finite or follow from those before them.

    Parameters
    ----------
    matrix : (n, p) array
    terms : sequence of str

    Raises
    ------
    RelightlabError
        Naming the first such column.
    """
    scale = np.linalg.norm(matrix, axis=0)
    if not np.isfinite(scale).all():
        raise RelightlabError(f"{terms[int(np.argmin(np.isfinite(scale)))]!r} has missing values")
    upper = triangular_factor(matrix / np.where(scale > 0, scale, 1.0))
    own = np.zeros(matrix.shape[1])
    own[: upper.shape[0]] = np.abs(np.diag(upper))
    if (own < 1e-9).any():
        raise RelightlabError(
            f"{terms[int(np.argmax(own < 1e-9))]!r} follows from the terms before it: leave it out"
            " of the formula"
        )


def triangular_factor(matrix: Float) -> Float:
    """Return the triangular factor R of the columns: their inner products are those of R.

    Parameters
    ----------
    matrix : (n, p) array

    Returns
    -------
    (min(n, p), p) array
    """
    return np.asarray(np.linalg.qr(matrix, mode="r"), dtype=float)
