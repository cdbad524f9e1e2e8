"""The section of the report about SIRFS itself: a fit as a figure, its errors, its weakness."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from reports.content import Block, Cell, Folded, Group, Pictures, Prose, Section, Table
from reports.rows_behind import Rows, rows_behind
from reports.sirfs_figure import significant, sirfs_figure
from reports.subject import Subject
from reports.table1_entries import has_rival

PREFERRED = ("raccoon",)
"""The object whose fit is shown, where the dataset has it; else its first."""
ERRORS = {
    "z_mae": "Z-MAE",
    "n_mae": "N-MAE",
    "s_mse": "s-MSE",
    "r_mse": "r-MSE",
    "rs_mse": "rs-MSE",
    "l_mse": "L-MSE",
    "mean": "mean",
}
"""Errors of a row, by their published names."""
COSTS = {"final_loss": "loss", "evaluations": "evaluations"}
COST_DIGITS = 4
INTRODUCTION = (
    "B+M is SIRFS, {shape, illumination and reflectance from shading} (Barron and Malik, TPAMI"
    " 2015), written anew from its formulas in its release 1.5. It explains one photograph by the"
    " shape, albedo and light that are likeliest together under priors learned from ten objects"
    " and a pool of natural lights. No code of the original is in it."
)
SUMMARY_CAPTION = (
    "Errors of SIRFS over sets of objects, geometric means: height in pixels after the best shift"
    " (Z-MAE), angle of the normals in radians (N-MAE), squared error of shading, albedo and light"
    " after the best scale (s-, r-, L-MSE), local squared error of albedo and shading (rs-MSE), and"
    " the geometric mean of the six. Its priors were trained on MIT_TRAIN."
)
OBJECTS_CAPTION = (
    "Errors of SIRFS for every object, {place}; its final loss, and evaluations of it."
)

Row = Mapping[str, Any]


def sirfs_section(subject: Subject) -> Section | None:
    """Return what there is to show of SIRFS, None where a run left it out.

    Parameters
    ----------
    subject : Subject
        Its document may have ``sirfs_rows``, one for each fit, and ``sirfs_summary``, the same
        over sets of objects, see `evaluation.sirfs_grid.SirfsTable`.

    Returns
    -------
    Section or None
    """
    document = subject.document
    if not has_rival(document):
        return None
    rows, summary = (document.get(part) or [] for part in ("sirfs_rows", "sirfs_summary"))
    blocks: tuple[Block, ...] = (
        *_fit_pictures(subject),
        *([_summary_table(document, summary)] if summary else []),
        *_object_tables(document, rows),
        *(Prose(text) for text in weakness(document)),
    )
    return Section("sirfs", "SIRFS, the rival", (Prose(INTRODUCTION), *blocks))


def weakness(document: Mapping[str, Any]) -> tuple[str, ...]:
    """Return where SIRFS is poor, in sentences measured on the result; none without its rows.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    tuple of str
        Paragraphs.

    Examples
    --------
    >>> rows = [{"object": "cup", "channels": "color", "setting": setting, "r_mse": error}
    ...         for setting, error in (("natural", 0.001), ("laboratory", 0.004))]
    >>> weakness({"sirfs_rows": rows, "intrinsic": []})[0][:55]
    '{Where SIRFS is poor.} It has no part for cast shadows.'
    """
    rows = document.get("sirfs_rows") or []
    ratios = _laboratory_over_natural(rows, "r_mse")
    texts = [_shadow_words(ratios)] if ratios else []
    beside = _beside_retinex(rows, document["intrinsic"]) if rows else ""
    return (*texts, *([beside] if beside else []))


def _fit_pictures(subject: Subject) -> Iterable[Pictures]:
    (name,) = subject.preferred(PREFERRED, 1)
    setting = subject.photographed_setting
    fit = subject.fitted(name, setting)
    if fit is not None:
        figure = sirfs_figure(fit, subject.dataset.load(name, setting))
        yield Pictures(figure, _rows(subject.document, "sirfs_rows"))


def _rows(document: Mapping[str, Any], part: str) -> Rows:
    return rows_behind(document, part if document.get(part) else "objects")


def _summary_table(document: Mapping[str, Any], summary: Sequence[Row]) -> Table:
    head = tuple(Cell(word, role="head") for word in ("Set", "objects", *ERRORS.values()))
    groups = tuple(
        Group(
            place,
            tuple(
                (
                    Cell(row["object"], role="head"),
                    Cell(str(row["objects"])),
                    *_numbers(row, ERRORS),
                )
                for row in own
            ),
        )
        for place, own in _by_place(summary).items()
    )
    behind = rows_behind(document, "sirfs_summary")
    return Table("sirfs-summary", SUMMARY_CAPTION, (head,), groups, behind)


def _object_tables(document: Mapping[str, Any], rows: Sequence[Row]) -> Iterable[Folded]:
    """Yield the tables of every object, folded, one for each setting and number of channels."""
    words = ("Object", *ERRORS.values(), *COSTS.values())
    head = tuple(Cell(word, role="head") for word in words)
    behind = rows_behind(document, "sirfs_rows") if rows else None
    tables = tuple(
        Table(
            f"sirfs-{place.replace(', ', '-')}",
            OBJECTS_CAPTION.format(place=place),
            (head,),
            (Group("", tuple(_object_cells(row) for row in own)),),
            behind,
        )
        for place, own in _by_place(rows).items()
    )
    if tables:
        yield Folded("Errors of SIRFS by object", tables)


def _object_cells(row: Row) -> tuple[Cell, ...]:
    errors, costs = _numbers(row, ERRORS), _numbers(row, COSTS, COST_DIGITS)
    return (Cell(row["object"], role="head"), *errors, *costs)


def _numbers(row: Row, keys: Iterable[str], digits: int = 3) -> list[Cell]:
    return [Cell(significant(row[key], digits)) for key in keys]


def _by_place(rows: Sequence[Row]) -> dict[str, list[Row]]:
    found: dict[str, list[Row]] = {}
    for row in rows:
        colour = {"color": "colour"}.get(row["channels"], row["channels"])
        found.setdefault(f"{row['setting']}, {colour}", []).append(row)
    return found


def _laboratory_over_natural(rows: Sequence[Row], error: str) -> dict[str, float]:
    """Return how many times as large an error is in the laboratory, by object, in colour."""
    errors = {
        (row["object"], row["setting"]): row[error]
        for row in rows
        if row["channels"] == "color" and row[error]
    }
    return {
        name: value / errors[name, "natural"]
        for (name, setting), value in errors.items()
        if setting == "laboratory" and (name, "natural") in errors
    }


def _shadow_words(ratios: Mapping[str, float]) -> str:
    worst = max(ratios, key=lambda name: ratios[name])
    higher = sum(ratio > 1 for ratio in ratios.values())
    return (
        "{Where SIRFS is poor.} It has no part for cast shadows. A natural photograph of these sets"
        " is made without any; in the laboratory one they are there, and since albedo times shading"
        " has to be the photograph, what the shading of a smooth shape cannot darken ends up in the"
        " albedo, or bends the shape. Measured: from natural to laboratory the squared error of its"
        f" albedo (r-MSE) grows for {higher} of {len(ratios)} objects, {_times(ratios)} in the"
        f" median and {significant(ratios[worst])} times for {worst}; light between surfaces and"
        " noise, which only real photographs have, are in that, too."
    )


def _times(ratios: Mapping[str, float]) -> str:
    return f"{significant(float(np.median(list(ratios.values()))))} times"


def _beside_retinex(rows: Sequence[Row], intrinsic: Sequence[Row]) -> str:
    """Return how often it is closer to the true albedo and shading than Retinex, by setting."""
    retinex = {(row["object"], row["setting"]): row["lmse"] for row in intrinsic}
    counts: dict[str, list[bool]] = {}
    for row in rows:
        other = retinex.get((row["object"], row["setting"]))
        if row["channels"] == "color" and row.get("rs_mse") is not None and other is not None:
            counts.setdefault(row["setting"], []).append(row["rs_mse"] < other)
    shares = [
        f"for {sum(closer)} of {len(closer)} objects on the {setting} photographs"
        for setting, closer in counts.items()
    ]
    if not shares:
        return ""
    return (
        "By the local error of albedo and shading (rs-MSE, the LMSE of the tables by object) SIRFS"
        f" is closer to the truth than Retinex {', and '.join(shares)}."
    )
