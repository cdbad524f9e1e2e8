"""Table 1 as text: every entry with the published value beside it, what is left out in sight."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import typer

from reports.table1_entries import LEFT_OUT, NO_RULE, RIVAL, is_quick

COLUMNS = ("setting", "method", "details", "weights", "IMSE", "relative", "published")
TITLE = "Table 1: re-rendering error (published: on MIT-Berkeley, under other lights)"
RIVAL_WORDS = ("B + M", "SIRFS", "none")
"""Method, details and weights of the row of SIRFS itself."""
INCOMPLETE = 3
"""Exit code of a command whose table lacks cells."""
SHOWN_MISSING = 10
DETAILS = {
    "default": "(a) Retinex",
    "sirfs-shading": "(b) SIRFS shading",
    "gt-shading": "(c) true shading",
    "own": "its own",
}

Row = Mapping[str, Any]


def table1_lines(document: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the lines of the printed table, one for each entry, measured or left out.

    Parameters
    ----------
    document : mapping
        Of `evaluation.table1_results.table1_document`.

    Returns
    -------
    list of tuples of str
        In the order of `COLUMNS`; an empty tuple between settings.

    Examples
    --------
    >>> entry = {"setting": "natural", "method": "ours", "detail_source": "default",
    ...          "weights": "oracle"}
    >>> table1_lines({"rows": [{**entry, "imse": 0.005, "relative_imse": 0.08}], "baselines": [],
    ...               "published": [{**entry, "imse": 0.0329}], "open": []})
    [('natural', 'ours', '(a) Retinex', 'oracle', '0.00500', '0.080', '0.0329')]
    """
    settings = list(dict.fromkeys(row["setting"] for row in document["rows"]))
    lines: list[tuple[str, ...]] = []
    for setting in settings:
        lines += [()] if lines else []
        lines += _setting_lines(document, setting)
    return lines


def table1_title(document: Mapping[str, Any]) -> str:
    """Return the title of the printed table, which says what is left out and what is missing.

    Parameters
    ----------
    document : mapping
        Of `evaluation.table1_results.table1_document`.

    Returns
    -------
    str

    Examples
    --------
    >>> table1_title({"missing": [{"object": "sun", "reason": "not measured"}]})[:27]
    'INCOMPLETE, 1 cell missing.'
    >>> table1_title({"missing": [], "quick": True})[:21]
    'QUICK, without SIRFS.'
    """
    missing = len(document["missing"])
    stamps = ["QUICK, without SIRFS."] if is_quick(document) else []
    if missing:
        stamps.append(f"INCOMPLETE, {missing} cell{'s' if missing > 1 else ''} missing.")
    return " ".join([*stamps, TITLE])


def summary_lines(document: Mapping[str, Any]) -> list[str]:
    """Return what a run came to, in five lines.

    Parameters
    ----------
    document : mapping
        Of `evaluation.table1_results.table1_document`.

    Returns
    -------
    list of str
    """
    origin, protocol = document["provenance"], document["protocol"]
    objects = len({row["object"] for row in document["objects"]})
    measured = (
        f"{origin['dataset']}: {objects} objects under {protocol['lights']} lights, protocol"
        f" {protocol['name']} version {protocol['version']}, {protocol['channels']}"
    )
    left_out = "; rows (b) and B+M left out by --quick" if is_quick(document) else ""
    counted = f"{origin['cells_done']} cells done, {origin['cells_missing']} missing{left_out}"
    came_from = (
        f"{origin['seconds']:.1f} s, workers: {origin['workers']},"
        f" code {origin['commit'][:12]}, data {origin['data_hash'][:12]}"
    )
    settings = [_comparison(document, setting) for setting in ("natural", "laboratory")]
    return [measured, *settings, counted, came_from]


def stop_if_incomplete(document: Mapping[str, Any]) -> None:
    """End the command with exit code 3 if cells of the table are missing, and name them.

    Parameters
    ----------
    document : mapping
        Of `evaluation.table1_results.table1_document`.

    Raises
    ------
    typer.Exit
        With code `INCOMPLETE`.
    """
    missing = document["missing"]
    if not missing:
        return
    typer.echo(f"INCOMPLETE: {len(missing)} cells are missing from the table", err=True)
    for cell in missing[:SHOWN_MISSING]:
        words = [value for axis, value in cell.items() if axis != "reason"]
        typer.echo(f"  {' '.join(words)}: {cell['reason']}", err=True)
    if len(missing) > SHOWN_MISSING:
        typer.echo(f"  and {len(missing) - SHOWN_MISSING} more, all in the JSON", err=True)
    raise typer.Exit(INCOMPLETE)


def _setting_lines(document: Mapping[str, Any], setting: str) -> list[tuple[str, ...]]:
    rows = [row for row in document["rows"] if row["setting"] == setting]
    flat = [row for row in document["baselines"] if row["setting"] == setting]
    lines = [_line(row, (row["method"], "flat shape, Retinex", "constant"), "-") for row in flat]
    lines += [_line(r, RIVAL_WORDS, _published(document, r)) for r in rows if _is_rival(r)]
    lines += _left_out_lines(document, setting, RIVAL)
    for source, words in DETAILS.items():
        lines += [
            _line(row, (row["method"], words, row["weights"]), _published(document, row))
            for row in rows
            if row["detail_source"] == source and not _is_rival(row)
        ]
        if source == "sirfs-shading":
            lines += _left_out_lines(document, setting, "ours")
    return lines


def _is_rival(row: Row) -> bool:
    """Return whether a row is that of SIRFS itself, which has no weights to choose."""
    cell = row["method"], row["detail_source"], row["weights"]
    return cell == (RIVAL, "default", NO_RULE)


def _line(row: Row, words: tuple[str, str, str], published: str) -> tuple[str, ...]:
    numbers = _number(row["imse"], 5), _number(row["relative_imse"], 3)
    return (row["setting"], *words, *numbers, published)


def _left_out_lines(
    document: Mapping[str, Any], setting: str, method: str
) -> list[tuple[str, ...]]:
    """Return the published entries of a method that a quick run leaves out."""
    left_out = {(e["setting"], e["method"], e["detail_source"]) for e in document["open"]}
    found = [
        entry
        for entry in document["published"]
        if (entry["setting"], entry["method"]) == (setting, method)
        and (setting, method, entry["detail_source"]) in left_out
    ]
    return [
        (
            setting,
            *(RIVAL_WORDS if _is_rival(e) else (method, DETAILS[e["detail_source"]], e["weights"])),
            *(LEFT_OUT, "-", _number(e["imse"], 4)),
        )
        for e in found
    ]


def _published(document: Mapping[str, Any], row: Row) -> str:
    keys = ("setting", "method", "detail_source", "weights")
    for entry in document["published"]:
        if all(entry[key] == row[key] for key in keys):
            return _number(entry["imse"], 4)
    return "-"


def _comparison(document: Mapping[str, Any], setting: str) -> str:
    found = {
        "B+M" if _is_rival(row) else row["weights"]: row
        for row in document["rows"]
        if row["setting"] == setting
        and (_is_rival(row) or (row["method"], row["detail_source"]) == ("ours", "default"))
    }
    shown = [
        f"{words} {_number(row['imse'], 5)} ({_published(document, row)} published)"
        for words in ("regression", "oracle", "B+M")
        if (row := found.get(words))
    ]
    return f"{setting}: IMSE {', '.join(shown) or 'not measured'}"


def _number(value: float | None, decimals: int) -> str:
    return "-" if value is None else f"{value:.{decimals}f}"
