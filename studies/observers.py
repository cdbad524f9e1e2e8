"""Simulated observers: crossed-logit models of how subjects choose, and their answers.

An observer takes the target of a pair with the log odds

    logit(rate of the task) + subject + item + side * (+-1/2) + learning * (position - middle)
    + expertise * (declared expertise)

where subject and item effects are normal; a lapse is a coin toss. Everything about an observer
comes from names (the study's hash, a seed, the observer's number), so adding observers changes
none of the others.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from scipy.special import expit, logit

from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from shading_model.seeds import generator_for
from studies.questionnaire_answers import NO, YES
from studies.study_records import Question, Study

LEFT_SIGN = MappingProxyType({"left": 0.5, "right": -0.5})
YOUNGEST, OLDEST = 18.0, 70.0
TYPICAL_REACTION_MS = 2500.0
REACTION_SPREAD = 0.5
"""Standard deviation of the logarithm of reaction times."""


@dataclass(frozen=True)
class ObserverModel:
    """How a population of simulated observers chooses.

    Parameters
    ----------
    rates : mapping of str to float
        By task: how often the typical observer takes the target of the typical pair, without
        lapses; in (0, 1).
    rate : float
        The same for tasks that are not named.
    subject_sd, item_sd : float
        Standard deviations of the effects of subjects and of a task's pairs, in log odds.
    side : float
        Log odds that a picture gains by standing on the left rather than on the right.
    learning : float
        Log odds that the target gains with every main trial.
    expertise : float
        Log odds that the target gains with observers who declare expertise, in every kind of trial.
    expert_share, lapse, tie, dropout : float
        Shares: of observers who declare expertise, of trials answered by a coin, of trials answered
        with a tie where the study allows it, of observers who stop before the end.
    qualification, closing : float
        Rates of the right picture in qualification and closing pairs.

    Raises
    ------
    RelightlabError
        If a rate is not between 0 and 1, a share not from 0 to 1, or a deviation is negative.
    """

    rates: Mapping[str, float] = field(default_factory=dict)
    rate: float = 0.5
    subject_sd: float = 0.5
    item_sd: float = 0.3
    side: float = 0.0
    learning: float = 0.0
    expertise: float = 0.0
    expert_share: float = 0.2
    lapse: float = 0.02
    tie: float = 0.0
    dropout: float = 0.0
    qualification: float = 0.99
    closing: float = 0.8

    def __post_init__(self) -> None:
        inner = {f"the rate of {task}": value for task, value in self.rates.items()}
        inner |= {name: getattr(self, name) for name in ("rate", "qualification", "closing")}
        shares = ("expert_share", "lapse", "tie", "dropout")
        for name, value in inner.items():
            if not 0 < value < 1:
                raise RelightlabError(f"expected {name} to be between 0 and 1, got {value:g}")
        for name in shares:
            if not 0 <= getattr(self, name) <= 1:
                raise RelightlabError(f"expected {name} from 0 to 1, got {getattr(self, name):g}")
        for name in ("subject_sd", "item_sd"):
            if not 0 <= getattr(self, name) < np.inf:
                raise RelightlabError(f"expected {name} from 0 up, got {getattr(self, name):g}")


@dataclass(frozen=True)
class ShownTrial:
    """What an observer needs to know of a trial to answer it as the model says.

    Parameters
    ----------
    kind : str
        ``qualification``, ``main`` or ``closing``.
    pair : str
    target_side : str
    position : int
        Among the observer's trials of that kind, from 1.
    """

    kind: str
    pair: str
    target_side: str
    position: int


@dataclass(frozen=True)
class ObserverAnswers:
    """An observer's answers to a whole schedule.

    Parameters
    ----------
    response : tuple of str
    reaction_ms : (n,) floats
    stops_after : int
        Trials answered before the observer leaves; n for one who stays.
    """

    response: tuple[str, ...]
    reaction_ms: Float
    stops_after: int


@dataclass(frozen=True)
class Observer:
    """One simulated subject.

    Parameters
    ----------
    study : Study
    model : ObserverModel
    seed, number : int

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> observer = Observer(bare_study(), ObserverModel(), seed=0, number=3)
    >>> trial = ShownTrial("main", "pair-1", "left", 1)
    >>> observer.name, observer.answers("task-1", [trial]).response
    ('...', ('...',))
    """

    study: Study
    model: ObserverModel
    seed: int
    number: int

    @property
    def name(self) -> str:
        """The opaque name, the same for the same study, seed and number."""
        parts = ("simulated", identity_of(self.study), self.seed, self.number)
        return hashlib.sha256("\x1f".join(map(str, parts)).encode()).hexdigest()[:16]

    @property
    def is_expert(self) -> bool:
        """Whether the observer declares expertise."""
        return bool(self._generator("expert").random() < self.model.expert_share)

    @property
    def effect(self) -> float:
        """What the observer adds to the log odds of every main trial."""
        return self.model.subject_sd * float(self._generator("effect").normal())

    def answers(self, task: str, trials: Sequence[ShownTrial]) -> ObserverAnswers:
        """Return the answers to a schedule; one trial's does not depend on the others'."""
        chance = choice_probabilities(self, task, trials)
        random = np.array([self._generator("trial", t.kind, t.pair).random(2) for t in trials])
        random = random.reshape(-1, 2)
        noise = self._generator("reaction").normal(size=len(trials))
        least = self.study.settings.minimum_view_ms
        reaction = least + TYPICAL_REACTION_MS * np.exp(REACTION_SPREAD * noise)
        tie = self.model.tie if self.study.settings.allow_tie else 0.0
        target = [t.target_side for t in trials]
        other = [{"left": "right", "right": "left"}[side] for side in target]
        response = np.where(random[:, 0] < chance, target, other)
        response = np.where(random[:, 1] < tie, "tie", response)
        generator = self._generator("dropout")
        leaves = generator.random() < self.model.dropout
        stop = int(generator.integers(len(trials))) if leaves and trials else len(trials)
        return ObserverAnswers(tuple(map(str, response)), np.round(reaction, 1), stop)

    def questionnaire(self) -> dict[str, str]:
        """Return answers to the study's questions; texts are left open unless required."""
        answers = {one.name: self._answer(one) for one in self.study.questionnaire}
        return {name: answer for name, answer in answers.items() if answer}

    def _answer(self, question: Question) -> str:
        generator = self._generator("question", question.name)
        if question.name == "expertise":
            words = YES if self.is_expert else NO
            fitting = [option for option in question.options if option.casefold() in words]
            return (fitting or list(question.options) or sorted(words, reverse=True))[0]
        if question.kind == "choice":
            return str(generator.choice(np.array(question.options)))
        if question.kind == "number":
            low = YOUNGEST if question.minimum is None else max(YOUNGEST, question.minimum)
            high = OLDEST if question.maximum is None else min(OLDEST, question.maximum)
            return f"{np.floor(generator.uniform(low, max(low, high))):g}"
        return "simulated" if question.required else ""

    def _generator(self, *names: str) -> np.random.Generator:
        return generator_for("observer", identity_of(self.study), self.seed, self.number, *names)


def identity_of(study: Study) -> str:
    """Return the study's hash; for one without pictures, which has none, the hash of its name.

    Parameters
    ----------
    study : Study

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> len(identity_of(bare_study()))
    64
    """
    return study.hash or hashlib.sha256(f"bare\x1f{study.name}".encode()).hexdigest()


def choice_probabilities(observer: Observer, task: str, trials: Sequence[ShownTrial]) -> Float:
    """Return how likely an observer takes the target of each trial, lapses included, ties not.

    Parameters
    ----------
    observer : Observer
    task : str
    trials : sequence of ShownTrial
        A subject's whole schedule: the middle of its main trials is where learning is nil.

    Returns
    -------
    (n,) array
    """
    model = observer.model
    expert = model.expertise * observer.is_expert
    middle = (1 + sum(trial.kind == "main" for trial in trials)) / 2
    log_odds = np.empty(len(trials))
    for index, trial in enumerate(trials):
        rate = {"qualification": model.qualification, "closing": model.closing}.get(
            trial.kind, model.rates.get(task, model.rate)
        )
        log_odds[index] = logit(rate) + expert + model.side * LEFT_SIGN[trial.target_side]
        if trial.kind == "main":
            log_odds[index] += observer.effect + item_effect(observer, task, trial.pair)
            log_odds[index] += model.learning * (trial.position - middle)
    chance: Float = model.lapse / 2 + (1 - model.lapse) * expit(log_odds)
    return chance


def item_effect(observer: Observer, task: str, pair: str) -> float:
    """Return the effect of a task's pair, the same for all observers of a seed, in log odds.

    Parameters
    ----------
    observer : Observer
    task, pair : str
    """
    generator = generator_for("item", identity_of(observer.study), observer.seed, task, pair)
    return observer.model.item_sd * float(generator.normal())
