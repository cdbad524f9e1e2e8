"""Formulas of models in R's notation: ``chose ~ baseline + (1|subject) + (1|item)``.

A term is a column, or several with ':' between them for their interaction. Columns of words stand
for an indicator of each level but the first, as R's treatment contrasts do.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd

from shading_model.arrays import Float
from shading_model.errors import RelightlabError, unknown_name

RANDOM = re.compile(r"\(\s*1\s*\|\s*(\w+)\s*\)")
NAME = re.compile(r"[A-Za-z_]\w*")
TERM = re.compile(r"[A-Za-z_]\w*(?:\s*:\s*[A-Za-z_]\w*)*")
INTERCEPT = "(Intercept)"


@dataclass(frozen=True)
class ModelFormula:
    """The parts of a formula.

    Parameters
    ----------
    outcome : str
    fixed : tuple of tuples of str
        The fixed effects beside the intercept: each the columns whose product it is.
    factors : tuple of str
        Columns with a random intercept for each level.
    """

    outcome: str
    fixed: tuple[tuple[str, ...], ...]
    factors: tuple[str, ...]

    def columns(self) -> tuple[str, ...]:
        """Return the columns that the formula needs."""
        fixed = (name for term in self.fixed for name in term)
        return tuple(dict.fromkeys((self.outcome, *fixed, *self.factors)))


def parse_formula(text: str) -> ModelFormula:
    """Return the parts of a formula.

    Parameters
    ----------
    text : str

    Returns
    -------
    ModelFormula

    Raises
    ------
    RelightlabError
        If it is no formula of sums, interactions and random intercepts.

    Examples
    --------
    >>> parse_formula("chose ~ baseline + (1|worker) + (1|question)")
    ModelFormula(outcome='chose', fixed=(('baseline',),), factors=('worker', 'question'))
    """
    left, tilde, right = text.partition("~")
    outcome, factors = left.strip(), tuple(RANDOM.findall(right))
    terms = [term.strip() for term in RANDOM.sub("", right).split("+")]
    fixed = [term for term in terms if term not in {"", "1"}]
    wrong = [term for term in fixed if not TERM.fullmatch(term)]
    if not tilde or not NAME.fullmatch(outcome) or wrong:
        raise RelightlabError(
            "expected a formula such as 'chose ~ baseline + (1|subject) + (1|item)', of columns,"
            f" '+', ':' and '(1|column)', got {text!r}"
        )
    columns = tuple(tuple(part.strip() for part in term.split(":")) for term in fixed)
    return ModelFormula(outcome, columns, factors)


def design_of(formula: ModelFormula, frame: pd.DataFrame) -> tuple[Float, tuple[str, ...]]:
    """Return the columns of the fixed effects and their names, as R names them.

    Parameters
    ----------
    formula : ModelFormula
    frame : DataFrame

    Returns
    -------
    matrix : (n, p) array
    terms : tuple of str
        ``(Intercept)`` first; a level's name follows its column's.

    Raises
    ------
    RelightlabError
        If a column is missing or has empty cells.

    Examples
    --------
    >>> frame = pd.DataFrame({"chose": [1, 0], "rival": ["a", "b"]})
    >>> design_of(parse_formula("chose ~ rival"), frame)[1]
    ('(Intercept)', 'rivalb')
    """
    for name in formula.columns():
        if name not in frame:
            raise unknown_name("column in the formula", name, list(frame.columns))
        if frame[name].isna().any():
            raise RelightlabError(
                f"expected a value in every row of the column {name!r}: leave rows without one out"
            )
    columns, terms = [np.ones(len(frame))], [INTERCEPT]
    for term in formula.fixed:
        for parts in product(*(_coded(frame[name]) for name in term)):
            terms.append(":".join(name for name, _ in parts))
            columns.append(np.prod([values for _, values in parts], axis=0))
    return np.column_stack(columns), tuple(terms)


def _coded(column: pd.Series) -> list[tuple[str, Float]]:
    """Return a column of numbers as it is, one of words as indicators, with their names."""
    if pd.api.types.is_numeric_dtype(column):
        return [(str(column.name), column.to_numpy(dtype=float))]
    words = column.astype(str)
    levels = sorted(words.unique())[1:]
    return [(f"{column.name}{level}", (words == level).to_numpy(dtype=float)) for level in levels]
