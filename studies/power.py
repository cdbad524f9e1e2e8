"""How many subjects a study needs, found by simulating it.

A curve gives the power of a planned test over the number of subjects in a task; what is needed is
where it crosses the wanted power, and the Monte-Carlo error says how surely.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.stats import norm

from shading_model.errors import RelightlabError
from shading_model.seeds import generator_for
from studies.power_simulation import (
    Scope,
    Sums,
    differs,
    draw_sums,
    estimate,
    intercept,
    is_equivalent,
)
from studies.study_records import Study

SIZES = (10, 15, 20, 30, 40, 60, 80, 120, 160, 240, 320, 480, 640, 960, 1280, 1920, 2560, 3840)
LARGEST = (240, 960, 3840)
"""Sizes up to which a curve is drawn; the next only if the power wanted is not reached."""
CELLS_AT_ONCE = 2_000_000
PLATEAU = 0.01
"""A curve that gains less than this over its last step has come to its end."""


@dataclass(frozen=True)
class Aim:
    """What a study is to show.

    Parameters
    ----------
    name : str
    rates : tuple of one or two floats
        The true rate; or those of two tasks or two groups, which are compared.
    margin : float or None
        The rate is to be shown within this of 0.5; None to show a difference.
    share : float or None
        Of two groups within a task, the share of subjects in the first; None for two tasks with
        as many subjects each.

    Raises
    ------
    RelightlabError
        If a rate, margin or share is out of its range, or equivalence is asked of two rates.

    Examples
    --------
    >>> Aim("experts differ", (0.66, 0.59), share=0.2).null
    0.0
    """

    name: str
    rates: tuple[float, ...]
    margin: float | None = None
    share: float | None = None

    def __post_init__(self) -> None:
        if not all(0 < rate < 1 for rate in self.rates) or len(self.rates) not in (1, 2):
            raise RelightlabError(
                f"{self.name}: expected one or two rates between 0 and 1, got {self.rates}"
            )
        if self.margin is not None and (not 0 < self.margin < 0.5 or len(self.rates) != 1):
            raise RelightlabError(
                f"{self.name}: expected a margin between 0 and 0.5, and one rate, got"
                f" {self.margin:g} and {self.rates}"
            )
        if self.share is not None and (not 0.01 <= self.share <= 0.99 or len(self.rates) != 2):
            raise RelightlabError(
                f"{self.name}: expected a share from 0.01 to 0.99, and two rates, got"
                f" {self.share:g} and {self.rates}"
            )

    @property
    def null(self) -> float:
        """Return what is to be excluded, or lies in the middle of the margins."""
        return 0.5 if len(self.rates) == 1 else 0.0


@dataclass(frozen=True)
class PowerModel:
    """What is taken for granted of subjects, pictures and the test.

    Parameters
    ----------
    pairs : int
        Pairs of a task.
    shown : int
        Of these, pairs of a subject.
    subject_sd, item_sd : float
        Standard deviations of the effects, in log odds.
    alpha : float
        Level of the test.
    tests : int
        Tests that are corrected together: each is held to alpha / tests, Holm's first step.
    """

    pairs: int = 10
    shown: int = 10
    subject_sd: float = 0.5
    item_sd: float = 0.3
    alpha: float = 0.05
    tests: int = 1

    def __post_init__(self) -> None:
        if self.pairs < 2 or not 1 <= self.shown <= self.pairs:
            raise RelightlabError(
                "expected two pairs or more, of which a subject sees at least one and at most all,"
                f" got {self.pairs} and {self.shown}"
            )
        for name in ("subject_sd", "item_sd"):
            if not 0 <= getattr(self, name) <= 10:
                raise RelightlabError(f"expected {name} from 0 to 10, got {getattr(self, name):g}")
        if not 0 < self.alpha < 1 or self.tests < 1:
            raise RelightlabError(
                "expected a level between 0 and 1 and one test or more,"
                f" got {self.alpha:g} and {self.tests}"
            )


@dataclass(frozen=True)
class PowerPoint:
    """The power at one size.

    Parameters
    ----------
    subjects : int
        In each task.
    power : float
        Share of simulated studies that show what they are to show.
    error : float
        Monte-Carlo standard error of the power.
    """

    subjects: int
    power: float
    error: float


@dataclass(frozen=True)
class PowerCurve:
    """The power of a test over the number of subjects in a task.

    Parameters
    ----------
    aim : str
    scope : {'these scenes', 'scenes like these'}
    points : tuple of PowerPoint
    wanted : float
    needed : int or None
        Subjects in each task at which the power wanted is reached; None if it is not.
    needed_low, needed_high : int or None
        The same with the curve 1.96 Monte-Carlo errors higher and lower.
    """

    aim: str
    scope: Scope
    points: tuple[PowerPoint, ...]
    wanted: float
    needed: int | None
    needed_low: int | None
    needed_high: int | None

    def document(self) -> dict[str, Any]:
        """Return the curve as plain values."""
        return asdict(self)


def model_of(study: Study, **changes: Any) -> PowerModel:
    """Return the power model of a study: its pairs and its level.

    Parameters
    ----------
    study : Study
        The task with the fewest pairs counts.
    **changes
        Other fields of `PowerModel`.

    Returns
    -------
    PowerModel

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> model_of(bare_study(pairs=12, pairs_per_subject=8), item_sd=0.0).shown
    8
    """
    pairs = min(len(task.pairs) for task in study.tasks)
    shown = study.settings.pairs_per_subject or pairs
    return PowerModel(pairs, shown, **({"alpha": study.analysis.alpha} | changes))


def power_curve(
    aim: Aim,
    model: PowerModel,
    scope: Scope = "these scenes",
    *,
    wanted: float = 0.8,
    draws: int = 2000,
    seed: int = 0,
) -> PowerCurve:
    """Return the power of an aim's test over sizes, and the size that gives the power wanted.

    Parameters
    ----------
    aim : Aim
    model : PowerModel
    scope : {'these scenes', 'scenes like these'}
        Whether the result is to hold for these pictures or for pictures like them. With few
        pictures, the second has a power that more subjects do not raise.
    wanted : float
    draws : int
        Simulated studies.
    seed : int

    Returns
    -------
    PowerCurve

    Raises
    ------
    RelightlabError
        If the power wanted or the number of draws is out of its range.

    Examples
    --------
    >>> curve = power_curve(Aim("60 % against 50 %", (0.6,)), PowerModel(), draws=500)
    >>> 25 < curve.needed < 50, curve.needed_low <= curve.needed <= curve.needed_high
    (True, True)
    """
    if not 0.05 <= wanted <= 0.999:
        raise RelightlabError(f"expected a power from 0.05 to 0.999, got {wanted:g}")
    if not 50 <= draws <= 1_000_000:
        raise RelightlabError(f"expected 50 to 1000000 draws, got {draws}")
    points: tuple[PowerPoint, ...] = ()
    for largest in LARGEST:
        sizes = [size for size in SIZES if size <= largest]
        points = _points(aim, model, scope, sizes, draws, generator_for("power", aim.name, seed))
        if points[-1].power > wanted or points[-1].power - points[-3].power < PLATEAU:
            break
    return PowerCurve(
        aim.name,
        scope,
        points,
        wanted,
        _needed(points, wanted, 0),
        _needed(points, wanted, 1.96),
        _needed(points, wanted, -1.96),
    )


def _points(
    aim: Aim,
    model: PowerModel,
    scope: Scope,
    sizes: Sequence[int],
    draws: int,
    generator: np.random.Generator,
) -> tuple[PowerPoint, ...]:
    shown = np.zeros(len(sizes))
    at_once = max(1, CELLS_AT_ONCE // (sizes[-1] * model.pairs))
    for done in range(0, draws, at_once):
        count = min(at_once, draws - done)
        arms = list(_arms(aim, model, scope, sizes, count, generator))
        shown += _succeeds(aim, model, arms, scope).sum(axis=0)
    power = shown / draws
    error = np.sqrt(power * (1 - power) / draws)
    values = zip(sizes, power.tolist(), error.tolist(), strict=True)
    return tuple(PowerPoint(*value) for value in values)


def _arms(
    aim: Aim,
    model: PowerModel,
    scope: Scope,
    sizes: Sequence[int],
    draws: int,
    generator: np.random.Generator,
) -> Iterator[Sums]:
    """Yield the simulated answers to one task, or to two, or of two groups to the same one."""
    effects = _item_effects(model, scope, draws, generator)
    for number, rate in enumerate(aim.rates):
        if number == 1 and aim.share is None:  # the pictures of another task
            effects = _item_effects(model, scope, draws, generator)
        own = sizes
        if aim.share is not None:
            first = [min(size - 2, max(2, round(size * aim.share))) for size in sizes]
            own = [size - one for size, one in zip(sizes, first, strict=True)] if number else first
        log_odds = intercept(rate, math.hypot(model.subject_sd, model.item_sd))
        yield draw_sums(log_odds, model.subject_sd, effects, own, model.shown, generator)


def _item_effects(
    model: PowerModel, scope: Scope, draws: int, generator: np.random.Generator
) -> npt.NDArray[np.float32]:
    effects = generator.standard_normal((draws, model.pairs), np.float32)
    if scope == "these scenes":  # the rate over these very pictures is the given one
        effects -= effects.mean(axis=1, keepdims=True)
    scaled: npt.NDArray[np.float32] = effects * np.float32(model.item_sd)
    return scaled


def _succeeds(
    aim: Aim, model: PowerModel, arms: Sequence[Sums], scope: Scope
) -> npt.NDArray[np.bool_]:
    found = estimate(arms, scope)
    alpha = model.alpha / model.tests
    if aim.margin is None:
        return differs(found, aim.null, alpha)
    return is_equivalent(found, aim.null, aim.margin, alpha)


def _needed(points: Sequence[PowerPoint], wanted: float, errors: float) -> int | None:
    """Return where the curve, raised by so many of its errors, crosses the power wanted.

    Between sizes, the normal quantile of the power is taken to be linear in the root of the size,
    as it is for a test whose standard error falls with that root.
    """
    roots = np.sqrt([point.subjects for point in points])
    power = np.array([point.power + errors * point.error for point in points])
    levels = norm.ppf(np.clip(np.maximum.accumulate(power), 1e-4, 1 - 1e-4))
    goal = float(norm.ppf(wanted))
    above = np.flatnonzero(levels >= goal)
    if not above.size:
        return None
    place = int(above[0])
    if place == 0:
        return points[0].subjects
    (low, high), (start, end) = levels[place - 1 : place + 1], roots[place - 1 : place + 1]
    root = start + (goal - low) / (high - low) * (end - start)
    return math.ceil(float(root) ** 2 - 1e-9)
