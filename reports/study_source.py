"""Where the answers of an analysis come from: a database, an export, or a file in a known form."""

from __future__ import annotations

from pathlib import Path

from shading_model.errors import RelightlabError
from studies.exporting import MANIFEST, read_export
from studies.response_store import ResponseStore
from studies.tables import StudyData

FIRST_BYTES = b"SQLite format 3\x00"
PILOT = ("pilot",)


def read_answers(source: str, *, pilot: bool = False) -> StudyData:
    """Return the answers of a database or of an export.

    Parameters
    ----------
    source : str
        ``postgresql://...`` or ``sqlite:///FILE``; path of a SQLite file; folder of an export, or
        one of its CSV files.
    pilot : bool
        Take pilot sessions alone; by default all but these.

    Returns
    -------
    StudyData

    Raises
    ------
    RelightlabError
        If there is no such source, it is of no known form, or it has no answers.
    """
    data = _read(source, pilot=pilot)
    if data.trials.empty:
        kind = "pilot answers" if pilot else "answers (a pilot's are read with --pilot)"
        raise RelightlabError(
            f"there are no {kind} in {source}: collect some with 'relightlab study serve', or"
            " make some up with 'relightlab study simulate'"
        )
    return data


def _read(source: str, *, pilot: bool) -> StudyData:
    if "://" in source:
        return _from_database(source, pilot=pilot)
    path = Path(source)
    if not path.exists():
        raise RelightlabError(
            f"{source} does not exist: expected a database, the folder of an export, or a CSV file"
            " with --mapping"
        )
    folder = path if path.is_dir() else path.parent
    if path.is_dir() or (path.suffix == ".csv" and (folder / MANIFEST).is_file()):
        return _of_mode(read_export(folder), pilot=pilot)
    with path.open("rb") as stream:
        known = stream.read(len(FIRST_BYTES)) == FIRST_BYTES
    if not known:
        raise RelightlabError(
            f"expected {source} to be a SQLite database or an export; for another CSV file give"
            " --mapping FILE, which says what its columns mean"
        )
    return _from_database(source, pilot=pilot)


def _from_database(address: str, *, pilot: bool) -> StudyData:
    store = ResponseStore(address, must_exist=True)
    try:
        return store.read(PILOT) if pilot else store.read()
    finally:
        store.close()


def _of_mode(data: StudyData, *, pilot: bool) -> StudyData:
    """Return the pilot's part of an export, or all but it; a pilot alone stays whole."""
    is_pilot = data.subjects["mode"].isin(PILOT)
    chosen = is_pilot if pilot else ~is_pilot
    if not pilot and is_pilot.all():
        return data
    return data.of_subjects(data.subjects.loc[chosen, "subject"])
