"""Sample sizes: beside closed forms, monotone in what they should be, and the same every time."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest
from scipy.stats import norm

from shading_model.errors import RelightlabError
from studies import power
from studies.bare_study import bare_study
from studies.power import Aim, PowerCurve, PowerModel, PowerPoint, model_of, power_curve

SIXTY = Aim("60 % against 50 %", (0.6,))


def needed(aim: Aim = SIXTY, draws: int = 1000, **changes: Any) -> int:
    """Return the subjects an aim needs."""
    found = power_curve(aim, replace(PowerModel(), **changes), draws=draws).needed
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("aim", "quantiles", "distance", "arms"),
    [
        (Aim("one rate", (0.6,)), norm.isf(0.025) + norm.isf(0.2), 0.1, 1),
        (Aim("two tasks", (0.6, 0.45)), norm.isf(0.025) + norm.isf(0.2), 0.15, 2),
        # Equivalent only if neither of two tests fails: each may in half of the cases.
        (Aim("equivalence", (0.5,), margin=0.08), norm.isf(0.05) + norm.isf(0.1), 0.08, 1),
    ],
)
def test_without_effects_sizes_are_the_textbook_ones(
    aim: Aim, quantiles: float, distance: float, arms: int
) -> None:
    """Where trials are independent, the normal approximation gives about the same number."""
    variance = sum(rate * (1 - rate) for rate in aim.rates)
    textbook = variance * (quantiles / distance) ** 2 / 20
    found = needed(aim, 4000, subject_sd=0.0, item_sd=0.0, pairs=20, shown=20)
    assert found == pytest.approx(textbook + 1.0, abs=2.5)
    assert len(aim.rates) == arms


def test_what_makes_answers_alike_costs_subjects() -> None:
    """More variance between subjects, fewer trials and more tests need more subjects."""
    plain = needed(subject_sd=0.0)
    assert needed(subject_sd=0.6) > plain
    assert needed(subject_sd=0.0, shown=5) > 1.5 * plain
    assert needed(subject_sd=0.0, tests=10) > plain


def test_a_small_group_costs_subjects() -> None:
    """A contrast with a fifth of the subjects needs more than one with half of them."""
    halves = Aim("halves", (0.7, 0.55), share=0.5)
    assert needed(replace(halves, share=0.2)) > needed(halves)


def test_other_pictures_are_harder_to_tell_of() -> None:
    """With ten pictures of great variance, more subjects do not make a result general."""
    model = PowerModel(item_sd=0.8)
    these = power_curve(SIXTY, model, "these scenes", draws=500)
    like_these = power_curve(SIXTY, model, "scenes like these", draws=500)
    assert these.needed is not None
    assert like_these.needed is None
    assert like_these.points[-1].power < 0.8


def test_a_curve_has_its_error() -> None:
    """Power grows with size, its error is binomial, and the size wanted lies in its range."""
    curve = power_curve(SIXTY, PowerModel(), draws=1000)
    assert [point.subjects for point in curve.points] == [n for n in power.SIZES if n <= 240]
    for point in curve.points:
        expected = (point.power * (1 - point.power) / 1000) ** 0.5
        assert point.error == pytest.approx(expected)
    assert all(b.power >= a.power - 0.02 for a, b in pairwise(curve.points))
    low, middle, high = curve.needed_low, curve.needed, curve.needed_high
    assert low is not None
    assert middle is not None
    assert high is not None
    assert low <= middle <= high


def test_a_seed_is_a_result() -> None:
    """The same seed gives the same curve, another one another within its error."""
    first = power_curve(SIXTY, PowerModel(), draws=300)
    assert power_curve(SIXTY, PowerModel(), draws=300) == first
    second = power_curve(SIXTY, PowerModel(), draws=300, seed=1)
    assert second != first
    for a, b in zip(first.points, second.points, strict=True):
        assert abs(a.power - b.power) < 5 * (a.error + b.error) + 0.01


def test_draws_in_parts_are_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where memory is short, studies are simulated in parts, with the same result in kind."""
    whole = power_curve(SIXTY, PowerModel(), draws=600)
    monkeypatch.setattr(power, "CELLS_AT_ONCE", 100_000)
    parts = power_curve(SIXTY, PowerModel(), draws=600)
    assert whole.needed is not None
    assert parts.needed == pytest.approx(whole.needed, abs=6)


def test_a_larger_curve_is_drawn_only_if_needed() -> None:
    """What a few subjects do not show is looked for among more."""
    curve = power_curve(Aim("53 %", (0.53,)), PowerModel(item_sd=0.0), draws=200)
    assert curve.points[-1].subjects == 960
    assert curve.needed is not None


def test_the_first_size_may_do() -> None:
    """Where the smallest size has the power wanted, that is the answer."""
    assert needed(Aim("95 %", (0.95,)), draws=100) == power.SIZES[0]


def test_sizes_between_are_interpolated() -> None:
    """A crossing halfway between two sizes lies between them, rounded up."""
    points = (PowerPoint(100, 0.5, 0.0), PowerPoint(400, 0.95, 0.0))
    halfway = norm.cdf(norm.ppf(0.95) / 2)
    assert power._needed(points, float(halfway), 0.0) == 225


def test_a_study_gives_its_own_model() -> None:
    """Pairs, trials and level are those of the study."""
    model = model_of(bare_study(pairs=12, pairs_per_subject=8), subject_sd=0.1)
    assert (model.pairs, model.shown, model.alpha, model.subject_sd) == (12, 8, 0.05, 0.1)


def test_a_curve_is_plain_values() -> None:
    """The JSON has the points and what was wanted."""
    curve = PowerCurve("a", "these scenes", (PowerPoint(10, 0.5, 0.1),), 0.8, None, None, None)
    assert curve.document()["points"] == ({"subjects": 10, "power": 0.5, "error": 0.1},)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Aim("a", (0.0,)), "one or two rates between 0 and 1"),
        (lambda: Aim("a", (0.1, 0.2, 0.3)), "one or two rates"),
        (lambda: Aim("a", (0.5,), margin=0.5), "a margin between 0 and 0.5"),
        (lambda: Aim("a", (0.5, 0.6), margin=0.1), "and one rate"),
        (lambda: Aim("a", (0.5,), share=0.2), "and two rates"),
        (lambda: Aim("a", (0.5, 0.6), share=0.0), "a share from 0.01 to 0.99"),
        (lambda: PowerModel(pairs=1, shown=1), "two pairs or more"),
        (lambda: PowerModel(shown=11), "at least one and at most all"),
        (lambda: PowerModel(item_sd=-1), "item_sd from 0 to 10, got -1"),
        (lambda: PowerModel(subject_sd=float("nan")), "subject_sd from 0 to 10"),
        (lambda: PowerModel(tests=0), "one test or more"),
        (lambda: power_curve(SIXTY, PowerModel(), wanted=1.0), "power from 0.05 to 0.999"),
        (lambda: power_curve(SIXTY, PowerModel(), draws=10), "50 to 1000000 draws"),
    ],
)
def test_wrong_numbers_are_refused(make: Any, words: str) -> None:
    """Rates, margins, shares and counts out of their range have a sentence each."""
    with pytest.raises(RelightlabError, match=words):
        make()
