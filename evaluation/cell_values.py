"""The numbers a row keeps of a re-rendering cell: all that its error at any weights depends on."""

from __future__ import annotations

import numpy as np

from evaluation.experiment import Values
from evaluation.rerendering import RerenderingCell

_GRAM = {"gram_cc": (0, 0), "gram_cp": (0, 1), "gram_cg": (0, 2), "gram_pp": (1, 1),
         "gram_pg": (1, 2), "gram_gg": (2, 2)}  # fmt: skip
_CROSS = ("cross_c", "cross_p", "cross_g")


def cell_values(cell: RerenderingCell) -> dict[str, float]:
    """Return the inner products of a cell by name.

    Parameters
    ----------
    cell : RerenderingCell

    Returns
    -------
    dict of float
        Ten numbers: ``gram_cc`` and so on (c, p, g: coarse, parametric, geometric), ``cross_c`` and
        so on, ``power``.
    """
    values = {name: float(cell.gram[place]) for name, place in _GRAM.items()}
    values.update(zip(_CROSS, cell.cross.tolist(), strict=True))
    return {**values, "power": cell.power}


def cell_of_values(values: Values) -> RerenderingCell:
    """Return the cell that `cell_values` was given; what is missing is NaN.

    Parameters
    ----------
    values : mapping of float

    Returns
    -------
    RerenderingCell

    Examples
    --------
    >>> cell = RerenderingCell(np.eye(3), np.ones(3), 2.0)
    >>> cell_values(cell_of_values(cell_values(cell))) == cell_values(cell)
    True
    """
    gram = np.full((3, 3), np.nan)
    for name, (row, column) in _GRAM.items():
        gram[row, column] = gram[column, row] = values.get(name, np.nan)
    cross = np.array([values.get(name, np.nan) for name in _CROSS])
    return RerenderingCell(gram, cross, values.get("power", float("nan")))
