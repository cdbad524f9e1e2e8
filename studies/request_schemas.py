"""What the page may send: strict, bounded, and nothing besides."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints

from studies.session_records import Display, Response, TrialAnswer

LONGEST_TEXT = 20_000
_YEAR_MS = 366 * 86_400_000.0  # a page may be left open over a holiday, and its answer counts


def clean(text: str) -> str:
    r"""Return a text that every database takes: no NUL, no half of a surrogate pair.

    Parameters
    ----------
    text : str

    Examples
    --------
    >>> clean("a\0b\ud800c")
    'ab?c'
    """
    return text.replace("\0", "").encode("utf-8", "replace").decode()


Text = Annotated[str, AfterValidator(clean), StringConstraints(max_length=LONGEST_TEXT)]
Short = Annotated[str, AfterValidator(clean), StringConstraints(max_length=256)]
Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_-]{1,64}$")]
Milliseconds = Annotated[float, Field(ge=0, le=_YEAR_MS)]
Pixels = Annotated[float, Field(ge=0, le=100_000)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class DisplaySchema(_Strict):
    """A subject's window."""

    width: Pixels | None = None
    height: Pixels | None = None
    pixel_ratio: Annotated[float, Field(gt=0, le=100)] | None = None


class OpeningSchema(_Strict):
    """The body of ``POST api/sessions``."""

    ids: Annotated[dict[Short, Short], Field(max_length=20)] = Field(default_factory=dict)
    mode: Literal["live", "pilot", "simulated"] | None = None
    display: DisplaySchema | None = None

    def window(self) -> Display:
        """Return the window as the store takes it."""
        return Display(**(self.display.model_dump() if self.display else {}))


class AnswerSchema(_Strict):
    """The body of ``PUT api/sessions/{token}/trials/{trial}``."""

    response: Response
    shown_ms: Milliseconds
    reaction_ms: Milliseconds
    blur_events: Annotated[int, Field(ge=0, le=1_000_000)]
    display_width: Pixels
    display_height: Pixels
    client_time: Short | None = None

    def answer(self) -> TrialAnswer:
        """Return the answer as the store takes it."""
        return TrialAnswer(**self.model_dump())


class EventSchema(_Strict):
    """The body of ``POST api/sessions/{token}/events``."""

    event: Name
    detail: Annotated[Text, StringConstraints(max_length=2000)] | None = None
    client_time: Short | None = None
    key: Short | None = None


class QuestionnaireSchema(_Strict):
    """The body of ``PUT api/sessions/{token}/questionnaire``."""

    answers: Annotated[dict[Short, Text | float | int | None], Field(max_length=200)]


class CompletionSchema(_Strict):
    """The body of ``POST api/sessions/{token}/completion``: nothing."""
