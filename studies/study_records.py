"""What a study consists of, as `studies.study_file.load_study` returns it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

QuestionKind = Literal["choice", "number", "text"]


@dataclass(frozen=True)
class Pair:
    """Two pictures to choose between.

    Parameters
    ----------
    name : str
        The item: unique in its task; the same name in several tasks is the same scene.
    target : str
        Path of the picture whose choice is counted, relative to the study's folder, with '/': the
        own method's; the real one of a qualification pair; the plausible one of a closing pair.
    other : str
        Path of the picture beside it.
    """

    name: str
    target: str
    other: str


@dataclass(frozen=True)
class ClosingPair(Pair):
    """A test of the subject at the end, named ``spheres`` or ``perspective``.

    Parameters
    ----------
    question : str
        What is asked about this pair; the study's question if empty.
    """

    question: str = ""


@dataclass(frozen=True)
class Task:
    """The pairs of one comparison; a subject does one task.

    Parameters
    ----------
    name : str
    title : str
        For tables and figures; subjects do not see it.
    target, other : str
        The conditions of the pairs' two pictures: ``ours`` and ``real``.
    pairs : tuple of Pair
    family : str
        Tasks of one family are reported beside each other and corrected together.
    """

    name: str
    title: str
    target: str
    other: str
    pairs: tuple[Pair, ...]
    family: str


@dataclass(frozen=True)
class Question:
    """A question of the closing questionnaire.

    Parameters
    ----------
    name : str
        ``gender``, ``age`` and ``expertise`` are read as the subject's; others are only kept.
    text : str
    kind : {'choice', 'number', 'text'}
    options : tuple of str
        What can be chosen; empty for other kinds.
    required : bool
    minimum, maximum : float or None
        Bounds of a number.
    maximum_length : int
        Characters of a text.
    """

    name: str
    text: str
    kind: QuestionKind
    options: tuple[str, ...] = ()
    required: bool = False
    minimum: float | None = None
    maximum: float | None = None
    maximum_length: int = 2000


@dataclass(frozen=True)
class Recruitment:
    """How subjects come, and where they go.

    Parameters
    ----------
    completion_url : str
        Where a subject is sent at the end; ``{code}`` in it stands for the completion code. Empty
        if the code is only shown.
    id_parameters : tuple of str
        Parameters of the address that identify the subject to the panel, the subject's own first;
        none if anyone with the link may take part.
    """

    completion_url: str = ""
    id_parameters: tuple[str, ...] = ()


@dataclass(frozen=True)
class Exclusions:
    """The preregistered rules by which a subject's answers are left out.

    Parameters
    ----------
    qualification_all_correct : bool
        Leave out who chose any cartoon.
    complete_only : bool
        Leave out who did not finish.
    minimum_median_ms : float or None
        Leave out whose median reaction time over main trials is below this.
    maximum_same_side : float or None
        Leave out who answered more than this share of main trials on one side.
    maximum_blur_events : int or None
        Leave out who left the window more often than this during main trials.
    """

    qualification_all_correct: bool = True
    complete_only: bool = True
    minimum_median_ms: float | None = None
    maximum_same_side: float | None = None
    maximum_blur_events: int | None = None

    def in_words(self) -> tuple[str, ...]:
        """Return whom each rule leaves out."""
        rules = (
            (self.complete_only, "who did not finish"),
            (self.qualification_all_correct, "who chose a cartoon"),
            (self.minimum_median_ms, "who answered in less than {:g} ms (median)"),
            (self.maximum_same_side, "who chose one side in more than {:.0%} of trials"),
            (self.maximum_blur_events, "who left the window more than {} times"),
        )
        return tuple(
            words.format(value)
            for value, words in rules
            if value is not None and value is not False
        )


@dataclass(frozen=True)
class AnalysisPlan:
    """The planned analysis.

    Parameters
    ----------
    equivalence_margin : float
        A rate within 0.5 plus or minus this counts as chance.
    alpha : float
        Level of every test; intervals cover 1 - alpha.
    groups : tuple of str
        Of ``expertise, tests, gender, age, half``: the paper's subpopulations, in the order of
        the tables.
    age_threshold : float
        Years at which ``age`` divides.
    """

    equivalence_margin: float = 0.05
    alpha: float = 0.05
    groups: tuple[str, ...] = ("expertise", "tests", "gender", "age", "half")
    age_threshold: float = 25.0


@dataclass(frozen=True)
class TrialSettings:
    """How trials are shown.

    Parameters
    ----------
    question : str
        What is asked above the two pictures.
    minimum_view_ms : int
        How long the pictures are seen before an answer counts.
    allow_tie : bool
        Whether 'no difference' may be answered.
    pairs_per_subject : int or None
        Pairs of the task that a subject sees; None for all.
    minimum_width, minimum_height : int
        The least window in CSS pixels.
    allow_touch : bool
        Whether a touch screen without a pointer is let in.
    """

    question: str = "Which picture looks more realistic?"
    minimum_view_ms: int = 500
    allow_tie: bool = False
    pairs_per_subject: int | None = None
    minimum_width: int = 1000
    minimum_height: int = 600
    allow_touch: bool = False


@dataclass(frozen=True)
class Study:
    """A whole study, checked.

    Parameters
    ----------
    name, title : str
    seed : int
        What schedules are drawn with.
    consent, instructions : str
        Plain text in paragraphs parted by empty lines; shown as text, never as markup.
    tasks : tuple of Task
    qualification : tuple of Pair
        Cartoons beside real pictures, mixed among the first trials.
    closing : tuple of ClosingPair
    questionnaire : tuple of Question
    recruitment : Recruitment
    exclusions : Exclusions
    analysis : AnalysisPlan
    settings : TrialSettings
    folder : Path
        Where the study file lies.
    hash : str
        SHA-256 of the content and of the stimuli's bytes, 64 hexadecimal digits.
    """

    name: str
    title: str
    seed: int
    consent: str
    instructions: str
    tasks: tuple[Task, ...]
    qualification: tuple[Pair, ...]
    closing: tuple[ClosingPair, ...]
    questionnaire: tuple[Question, ...]
    recruitment: Recruitment
    exclusions: Exclusions
    analysis: AnalysisPlan
    settings: TrialSettings
    folder: Path
    hash: str

    def task(self, name: str) -> Task:
        """Return the task of that name; KeyError if there is none."""
        return {task.name: task for task in self.tasks}[name]

    def all_pairs(self) -> Iterator[Pair]:
        """Yield every pair: of qualification, tasks and closing."""
        yield from self.qualification
        for task in self.tasks:
            yield from task.pairs
        yield from self.closing

    def stimuli(self) -> tuple[str, ...]:
        """Return the path of every picture once, relative to the folder, sorted."""
        return tuple(
            sorted({path for pair in self.all_pairs() for path in (pair.target, pair.other)})
        )

    def stimulus_path(self, stimulus: str) -> Path:
        """Return where one of `stimuli()` lies."""
        return self.folder / stimulus
