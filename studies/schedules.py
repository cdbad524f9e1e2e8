"""Which pairs a subject sees, in which order and on which sides, decided before anyone comes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

TrialKind = Literal["qualification", "main", "closing"]
Side = Literal["left", "right"]


@dataclass(frozen=True)
class ScheduledTrial:
    """One trial as it will be shown.

    Parameters
    ----------
    kind : {'qualification', 'main', 'closing'}
    pair : str
        Name of the pair.
    left, right : str
        Paths of the stimuli, as in the study.
    target_side : {'left', 'right'}
        Where the pair's target is.
    condition : str
        The task's target condition; ``qualification`` or ``closing`` for the other kinds.
    """

    kind: TrialKind
    pair: str
    left: str
    right: str
    target_side: Side
    condition: str


@dataclass(frozen=True)
class Schedule:
    """What a subject of this task and order sees, from the first trial to the last.

    Parameters
    ----------
    task : str
    order : int
        0-based number among the task's schedules.
    entries : tuple of ScheduledTrial
    """

    task: str
    order: int
    entries: tuple[ScheduledTrial, ...]
