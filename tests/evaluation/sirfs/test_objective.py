"""The loss of SIRFS: gradients against differences, terms against plain NumPy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evaluation.sirfs.objective import Objective
from evaluation.sirfs.regions import PAIR_OFFSETS
from evaluation.sirfs.settings import TERMS, term_weights
from evaluation.sirfs.training_data import mean_curvature
from evaluation.sirfs.view import view_of
from shading_model.height_field import normals_of_slopes, slopes
from shading_model.illumination import harmonics
from tests.evaluation.sirfs.toy_problems import toy_point, toy_priors, toy_problem

STEP = 1e-8
"""The loss has kinks where albedo crosses a knot of a histogram; a step must not meet many."""
CASES = [(c, t) for c in ("gray", "color") for t in TERMS]


def directional(channels: str, terms: tuple[str, ...], views: int, of_height: bool) -> tuple:
    """The change of the loss along a random direction: by the gradient, and by differences."""
    problem = toy_problem(channels, terms, views)
    objective = Objective(problem)
    height, lights = toy_point(problem)
    along_height, along_lights = toy_point(problem, seed=8)
    if of_height:
        along_lights = np.zeros_like(along_lights)
    else:
        along_height = np.zeros_like(along_height)
    found = objective(height, lights)
    exact = np.vdot(found.by_height, along_height) + np.vdot(found.by_lights, along_lights)
    above, below = (
        objective(height + s * along_height, lights + s * along_lights).loss for s in (STEP, -STEP)
    )
    return exact, (above - below) / (2 * STEP), found


@pytest.mark.parametrize(("channels", "term"), CASES)
def test_gradient_by_height_of_every_term(channels: str, term: str) -> None:
    """Each term's gradient by the shape is that of finite differences."""
    exact, differences, found = directional(channels, (term,), 1, of_height=True)
    assert exact == pytest.approx(differences, rel=2e-4, abs=1e-7)
    assert found.terms[term] == pytest.approx(found.loss)


@pytest.mark.parametrize(("channels", "term"), [c for c in CASES if "albedo" in c[1]])
def test_gradient_by_light_of_the_albedo_terms(channels: str, term: str) -> None:
    """Each albedo term's gradient by the light is that of finite differences, and not zero."""
    exact, differences, _ = directional(channels, (term,), 1, of_height=False)
    assert exact == pytest.approx(differences, rel=2e-4, abs=1e-7)
    assert abs(exact) > 1e-5


def test_gradient_of_the_light_term() -> None:
    """The light's own term has the gradient of finite differences."""
    exact, differences, _ = directional("color", ("light",), 1, of_height=False)
    assert exact == pytest.approx(differences, rel=1e-6)


@pytest.mark.parametrize("of_height", [True, False])
def test_gradient_of_several_views(of_height: bool) -> None:
    """With two photographs of one shape, all terms together have the gradient of differences."""
    exact, differences, _ = directional("color", TERMS, 2, of_height)
    assert exact == pytest.approx(differences, rel=2e-4)


def test_equal_views_cost_what_one_costs() -> None:
    """Two equal photographs under equal lights cost exactly what one does."""
    one = toy_problem("color", views=1)
    height, lights = toy_point(one)
    view = one.views[0]
    image = np.moveaxis(np.exp(view.log_image), 0, -1)
    half = view_of(image, view.valid, toy_priors(), term_weights("laboratory", "color"), 0.5)
    two = replace(one, views=(half, half))
    alone = Objective(one)(height, lights).loss
    assert Objective(two)(height, np.repeat(lights, 2, axis=0)).loss == pytest.approx(alone)


@pytest.mark.parametrize("channels", ["gray", "color"])
def test_log_albedo_is_what_light_leaves(channels: str) -> None:
    """Log albedo is log intensity minus the harmonics of the normals times the light."""
    problem = toy_problem(channels)
    objective = Objective(problem)
    height, lights = toy_point(problem)
    objective(height, lights)
    view, whitening = problem.views[0], problem.whitening
    coefficients = (whitening.inverse @ lights[0] + whitening.mean).reshape(-1, 9)
    shading = harmonics(normals_of_slopes(*slopes(height))) @ coefficients.T
    expected = view.log_image - np.moveaxis(shading, -1, 0)
    inside = view.valid
    np.testing.assert_allclose(
        objective.log_albedo(0)[:, inside], expected[:, inside], rtol=1e-10, atol=1e-12
    )


def test_curvature_term_is_the_sum_over_pairs() -> None:
    """The smoothness of the shape is that of a plain loop over offsets and pixels."""
    problem = toy_problem("gray", ("curvature",))
    height, lights = toy_point(problem)
    height = height / 5
    inside, curvature = problem.views[0].valid, mean_curvature(height)
    mixture, total = toy_priors().curvature, 0.0
    rows, columns = np.nonzero(inside)
    for down, right in PAIR_OFFSETS:
        there_row, there_column = rows + down, columns + right
        fits = (there_row < inside.shape[0]) & (there_column >= 0)
        fits &= there_column < inside.shape[1]
        fits[fits] = inside[there_row[fits], there_column[fits]]
        change = (
            curvature[rows[fits], columns[fits]] - curvature[there_row[fits], there_column[fits]]
        )
        total += mixture.cost(np.hypot(change, 1e-4)).sum()
    expected = 6.7272 / 25 * total / inside.size
    assert Objective(problem)(height, lights).loss == pytest.approx(expected, rel=1e-5)


def test_terms_of_a_flat_shape() -> None:
    """A flat shape pays the floors of the slant term and of the table of curvature, no more."""
    problem = toy_problem("gray", ("slant", "curvature"))
    found = Objective(problem)(np.zeros(problem.shape), np.zeros((1, 9)))
    table, pairs = problem.curvature, problem.pairs
    knots = table.start + table.spacing * np.arange(table.values.size)
    count = (pairs[:, 2] - pairs[:, 1]).sum() / (problem.shape[0] * problem.shape[1])
    floor = np.interp(1e-4, knots, table.values)
    assert found.terms["slant"] == pytest.approx(2.3784 * 0.01)
    assert found.terms["curvature"] == pytest.approx(6.7272 / 25 * count * floor)


def test_an_offset_of_the_height_changes_nothing() -> None:
    """Without an external depth the loss does not know how far away the object is."""
    problem = toy_problem("color", tuple(term for term in TERMS if term != "depth"))
    height, lights = toy_point(problem)
    objective = Objective(problem)
    assert objective(height + 3.0, lights).loss == pytest.approx(objective(height, lights).loss)


def test_an_objective_remembers_nothing() -> None:
    """The same point gives the same bits, whatever was evaluated before."""
    problem = toy_problem("color", views=2)
    objective = Objective(problem)
    point = toy_point(problem)
    first = objective(*point)
    kept = first.loss, first.by_height.copy(), first.by_lights.copy()
    objective(*toy_point(problem, seed=11))
    again = objective(*point)
    assert again.loss == kept[0]
    assert np.array_equal(again.by_height, kept[1])
    assert np.array_equal(again.by_lights, kept[2])
