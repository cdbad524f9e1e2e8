"""The regression gate, which finds the cells that are worse than their record.

A cell is worse when its error exceeds the recorded one by more than a relative tolerance:

- `SAME_PLATFORM`, where the processor's kernels, the C library and all numeric packages are those
  of the record. There a repeated measurement agrees to the last bit, whatever the number of
  processes, and to 6e-12 with two BLAS threads instead of one, so the tolerance need only be above
  the rounding of the record (at most 1e-7 between two numbers of eight digits).
- `OTHER_PLATFORM` elsewhere. With OpenBLAS held to its kernels for Haswell or Nehalem instead of
  SkylakeX, NumPy without AVX instructions, and the synthetic set made anew by them, no cell moved
  by more than 1.4e-8; other versions of the solvers stop elsewhere within their own tolerances.
- In laboratory photographs that another platform rendered, where the set's fingerprint shows it:
  `RENDERED_ELSEWHERE`. Paths of light are drawn by the same numbers, but the noise is another one
  (why is not verified; rounding is a guess); between the platform of an earlier record and another
  one residual of a smooth shading moved by 4.9%, the errors by up to 1.5%.
- What comes of a fit of SIRFS is told by looser ones on another platform: `FIT_ELSEWHERE`, three
  times what rounding alone moved errors by, and `LOSS_ELSEWHERE`, twice what it moved losses by
  (see `evaluation.gate_sirfs`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from evaluation.gate_baseline import Baseline
from evaluation.gate_measurement import GateMeasurement
from shading_model.errors import RelightlabError

SAME_PLATFORM = 1e-6
OTHER_PLATFORM = 1e-4
RENDERED_ELSEWHERE = 0.1
FIT_ELSEWHERE, LOSS_ELSEWHERE = 0.3, 0.01
NOT_MEASURED = float("inf")
_NOTHING = 1e-12
"""Errors below this are zero."""


@dataclass(frozen=True)
class Change:
    """A cell that moved by more than the tolerance.

    Parameters
    ----------
    cell : str
        Setting, object, detail source, weight rule and light; setting, object and residual; or
        setting, object, ``sirfs`` and error of the fit.
    old : float
    new : float or None
        None if it could not be measured.
    """

    cell: str
    old: float
    new: float | None

    @property
    def relative(self) -> float:
        """Return by how much of its old value the error grew; infinite if not measured."""
        if self.new is None:
            return NOT_MEASURED
        return (self.new - self.old) / max(self.old, _NOTHING)


@dataclass(frozen=True, eq=False)
class Comparison:
    """A measurement beside its record.

    Parameters
    ----------
    dataset : str
    tolerance : float
    differing : tuple of str
        What differs between the platforms of record and measurement.
    compared : int
        Number of cells.
    worse, better : tuple of Change
        Largest change first.
    reasons : tuple of str
        Why cells could not be measured.
    """

    dataset: str
    tolerance: float
    differing: tuple[str, ...]
    compared: int
    worse: tuple[Change, ...]
    better: tuple[Change, ...]
    reasons: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Return whether no cell is worse."""
        return not self.worse

    def document(self) -> dict[str, Any]:
        """Return the comparison as plain JSON values."""
        return {
            "dataset": self.dataset,
            "passed": self.passed,
            "tolerance": self.tolerance,
            "differing": list(self.differing),
            "compared": self.compared,
            "worse": [_entry(change) for change in self.worse],
            "better": [_entry(change) for change in self.better],
            "reasons": list(self.reasons),
        }


def compare(baseline: Baseline, measured: GateMeasurement) -> Comparison:
    """Compare a measurement with its record, cell by cell.

    Parameters
    ----------
    baseline : Baseline
    measured : GateMeasurement

    Returns
    -------
    Comparison

    Raises
    ------
    RelightlabError
        If they are not comparable: another protocol, other content of the dataset, other cells.
    """
    recorded = baseline.measured
    obstacle = difference(recorded, measured)
    if obstacle:
        raise RelightlabError(
            f"cannot compare with the record of {recorded.dataset}: {obstacle}; if that is meant,"
            f" run 'relightlab gate record --dataset {recorded.dataset} --reason \"...\"'"
        )
    tolerance, differing = tolerance_between(recorded, measured)
    rendered = recorded.fingerprint != measured.fingerprint
    moved = [
        change
        for change in _changes(recorded, measured)
        if _size(change) > tolerance_of(change.cell, tolerance, rendered=rendered)
    ]
    moved.sort(key=lambda change: (-_size(change), change.cell))
    return Comparison(
        dataset=recorded.dataset,
        tolerance=tolerance,
        differing=differing,
        compared=recorded.size,
        worse=tuple(change for change in moved if change.relative > 0),
        better=tuple(change for change in moved if change.relative < 0),
        reasons=measured.reasons,
    )


def difference(recorded: GateMeasurement, measured: GateMeasurement) -> str | None:
    """Return why two measurements cannot be compared, None if they can.

    A set made on the spot has the same content if it was made alike; its files need not be the
    same, because their last digits, and how they are packed, depend on the platform.

    Parameters
    ----------
    recorded, measured : GateMeasurement

    Returns
    -------
    str or None
    """
    if recorded.protocol != measured.protocol:
        return f"it is of protocol {recorded.protocol}, this is {measured.protocol}"
    if recorded.content != measured.content:
        return (
            f"the content of the dataset is another ({recorded.content} recorded,"
            f" {measured.content} now)"
        )
    shapes = [{key: len(row) for key, row in one.errors.items()} for one in (recorded, measured)]
    if shapes[0] != shapes[1]:
        others = sorted(shapes[0].items() ^ shapes[1].items())
        return f"its cells are others, such as {others[0][0]!r}"
    return None


def tolerance_between(
    recorded: GateMeasurement, measured: GateMeasurement
) -> tuple[float, tuple[str, ...]]:
    """Return the relative tolerance between two measurements, and what differs.

    Parameters
    ----------
    recorded, measured : GateMeasurement

    Returns
    -------
    float, tuple of str
    """
    was, now = recorded.platform, measured.platform
    differing = tuple(
        f"{name} {was.get(name, 'none')}, now {now.get(name, 'none')}"
        for name in sorted({*was, *now})
        if was.get(name) != now.get(name)
    )
    return (OTHER_PLATFORM if differing else SAME_PLATFORM), differing


def tolerance_of(cell: str, tolerance: float, *, rendered: bool = False) -> float:
    """Return the relative tolerance of one number, given that of the platforms.

    Parameters
    ----------
    cell : str
        Its name, see `Change`.
    tolerance : float
        Of `tolerance_between`.
    rendered : bool
        Whether the photographs were rendered by another platform, to another noise.

    Returns
    -------
    float

    Examples
    --------
    >>> tolerance_of("natural pear sirfs none 00", OTHER_PLATFORM)
    0.3
    >>> tolerance_of("natural pear default oracle 00", OTHER_PLATFORM, rendered=True)
    0.0001
    """
    setting, _, source, *_ = cell.split()
    if tolerance <= SAME_PLATFORM:
        return tolerance
    noisy = rendered and setting == "laboratory"
    if source.startswith("sirfs"):
        return LOSS_ELSEWHERE if cell.endswith("final_loss") and not noisy else FIT_ELSEWHERE
    return RENDERED_ELSEWHERE if noisy else tolerance


def _changes(recorded: GateMeasurement, measured: GateMeasurement) -> Iterator[Change]:
    for key, row in recorded.errors.items():
        for light, (old, new) in enumerate(zip(row, measured.errors[key], strict=True)):
            # A record has every cell: `new_baseline` sees to it.
            cell = key if len(row) == 1 else f"{key} {light:02d}"
            yield Change(cell, old or 0.0, new)


def _size(change: Change) -> float:
    if change.new is not None and abs(change.new - change.old) <= _NOTHING:
        return 0.0
    return abs(change.relative)


def _entry(change: Change) -> dict[str, Any]:
    return {"cell": change.cell, "old": change.old, "new": change.new}
