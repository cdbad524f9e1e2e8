"""Table 1 as a JSON document: every number that is printed or drawn."""

from __future__ import annotations

from typing import Any

from evaluation.known_values import rows_without_nan
from evaluation.own_rows import OwnRows
from evaluation.provenance import Provenance
from evaluation.published_table1 import OPEN_ENTRIES, PUBLISHED
from evaluation.table1 import PROTOCOL, PROTOCOL_VERSION
from evaluation.table1_record import Table1


def table1_document(
    table: Table1, provenance: Provenance, own: OwnRows | None = None
) -> dict[str, Any]:
    """Return Table 1 with its rows, the published values, details by object, and provenance.

    Parameters
    ----------
    table : Table1
    provenance : Provenance
    own : OwnRows, optional
        Methods and models that the user added: more rows of the same keys.

    Returns
    -------
    dict
        ``rows``, one for each table entry; ``test_rows``, the same over the test objects of
        MIT-Berkeley, on which no prior of SIRFS was trained, empty for other datasets;
        ``baselines``, a flat shape with the Retinex albedo; ``published``; ``quick``, whether the
        entries that need SIRFS were left out; ``open``, those entries if they were; ``objects`` and
        ``intrinsic``, the same by object; ``own_objects``, by object for the user's rows;
        ``missing``, the cells that should be there but are not, with reasons; ``protocol``,
        ``provenance``. NaN becomes None.
    """
    return {
        "protocol": {
            "name": PROTOCOL,
            "version": PROTOCOL_VERSION,
            "channels": table.channels,
            "lights": len(table.coefficients),
            "manual_weights": [table.manual.parametric, table.manual.geometric],
        },
        "rows": rows_without_nan(table.rows() + (own.rows() if own else [])),
        "test_rows": rows_without_nan(table.test_rows()),
        "baselines": rows_without_nan(table.baselines()),
        "published": [dict(entry) for entry in PUBLISHED],
        "quick": table.quick,
        "open": [dict(entry) for entry in OPEN_ENTRIES] if table.quick else [],
        "objects": rows_without_nan(table.object_rows()),
        "own_objects": rows_without_nan(own.object_rows() if own else []),
        "intrinsic": rows_without_nan(table.intrinsic_rows()),
        "missing": [
            {**found.cell, "reason": found.reason}
            for found in (*table.missing_entries(), *(own.missing_entries() if own else ()))
        ],
        "provenance": provenance.document(),
    }
