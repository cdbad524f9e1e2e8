"""What passes between a subject's session and the store, and how the store says no."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import astuple, dataclass
from datetime import UTC, datetime
from typing import Literal

from shading_model.errors import RelightlabError
from studies.schedules import Schedule, ScheduledTrial

Response = Literal["left", "right", "tie"]
AckState = Literal["stored", "repeated", "kept-first"]


class UnknownSessionError(RelightlabError):
    """No session has this token."""


class UnknownTrialError(RelightlabError):
    """The schedule of the session has no trial of this number."""


class RefusedError(RelightlabError):
    """The session is not in a state for what was asked.

    Parameters
    ----------
    sentence : str
    missing : sequence of int
        Trials that have no answer yet.
    questions : sequence of str
        Required questions that have none.
    """

    def __init__(
        self, sentence: str, missing: Sequence[int] = (), questions: Sequence[str] = ()
    ) -> None:
        super().__init__(sentence)
        self.missing = tuple(missing)
        self.questions = tuple(questions)


@dataclass(frozen=True)
class TrialAnswer:
    """An answer to one trial, as the page sends it.

    Parameters
    ----------
    response : {'left', 'right', 'tie'}
    shown_ms, reaction_ms : float
        How long the pair was on view, and until the answer.
    blur_events : int
        How often the page lost the focus meanwhile.
    display_width, display_height : float
        The window in CSS pixels.
    client_time : str, optional
        What the subject's clock said; kept, never relied on.
    """

    response: Response
    shown_ms: float
    reaction_ms: float
    blur_events: int
    display_width: float
    display_height: float
    client_time: str | None = None


@dataclass(frozen=True)
class Acknowledgement:
    """What became of an answer: it is on disk when this is made.

    Parameters
    ----------
    trial : int
    state : {'stored', 'repeated', 'kept-first'}
        ``repeated`` if the same answer was there already; ``kept-first`` if another was, which
        stands: this one is kept as an event.
    """

    trial: int
    state: AckState


@dataclass(frozen=True)
class Display:
    """A subject's window: CSS pixels, and device pixels to a CSS pixel."""

    width: float | None = None
    height: float | None = None
    pixel_ratio: float | None = None


@dataclass(frozen=True)
class Session:
    """A session as the subject may go on with it.

    Parameters
    ----------
    token : str
        Opens the session; whoever has it is the subject.
    subject, study_hash, mode, status : str
        As in the table of subjects.
    schedule : Schedule
    answered : tuple of int
        Trials whose answers are stored.
    questionnaire : tuple of str
        Questions whose answers are stored.
    resumed : bool
        Whether the session was there before.
    """

    token: str
    subject: str
    study_hash: str
    mode: str
    status: str
    schedule: Schedule
    answered: tuple[int, ...] = ()
    questionnaire: tuple[str, ...] = ()
    resumed: bool = False


def schedule_to_text(schedule: Schedule) -> str:
    """Return a schedule as the text that is kept with a session.

    Parameters
    ----------
    schedule : Schedule

    Examples
    --------
    >>> schedule = Schedule("real", 0, ())
    >>> schedule_from_text(schedule_to_text(schedule)) == schedule
    True
    """
    entries = [astuple(entry) for entry in schedule.entries]
    return json.dumps({"task": schedule.task, "order": schedule.order, "entries": entries})


def schedule_from_text(text: str) -> Schedule:
    """Return the schedule that was kept as this text.

    Parameters
    ----------
    text : str
        From `schedule_to_text`.
    """
    kept = json.loads(text)
    entries = tuple(ScheduledTrial(*entry) for entry in kept["entries"])
    return Schedule(kept["task"], kept["order"], entries)


def now() -> datetime:
    """Return the instant, in UTC.

    Returns
    -------
    datetime
    """
    return datetime.now(UTC)


def iso(instant: datetime) -> str:
    """Return an instant as all tables write it, so that text order is time order.

    Parameters
    ----------
    instant : datetime
        In UTC.

    Examples
    --------
    >>> iso(datetime(2026, 11, 25, 14, 0, tzinfo=UTC))
    '2026-11-25T14:00:00.000Z'
    """
    return instant.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
