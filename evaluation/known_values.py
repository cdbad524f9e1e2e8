"""Numbers of which some are not known: NaN while they are counted, None in a document."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from shading_model.arrays import Float


def mean_of_known(values: Float) -> float:
    """Return the mean of the finite values, NaN if there are none.

    Parameters
    ----------
    values : array

    Returns
    -------
    float

    Examples
    --------
    >>> mean_of_known(np.array([1.0, np.nan, 3.0]))
    2.0
    """
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else float("nan")


def rows_without_nan(rows: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return rows with None, which JSON has, in place of NaN, which it does not have.

    Parameters
    ----------
    rows : iterable of mapping

    Returns
    -------
    list of dict

    Examples
    --------
    >>> rows_without_nan([{"imse": float("nan"), "object": "sun"}])
    [{'imse': None, 'object': 'sun'}]
    """
    return [{key: None if value != value else value for key, value in row.items()} for row in rows]  # noqa: PLR0124
