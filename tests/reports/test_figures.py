"""Tests of the figures: pictures, panels, plots, and the README's picture."""

from __future__ import annotations

import base64
import io
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from PIL import Image as PillowImage

from datasets.synthetic import synthesize
from reports.decomposition_figure import decomposition_figure
from reports.error_figure import object_error_figure, table_shape_figure
from reports.figures import DISPLAY_WIDTH, PanelFigure, panel
from reports.gallery_figure import best_scaled, gallery_figure, spread_over_errors
from reports.light_fit_figure import light_fit_figure
from reports.pictures import (
    data_uri,
    diverging_picture,
    diverging_stops,
    exposure,
    fitted,
    normal_picture,
    photograph_picture,
    sphere_picture,
    symmetric_limit,
    with_light,
)
from reports.readme_picture import CONTRAST, lamp, main, write_readme_picture
from reports.style import page_svg, plot_style
from reports.subject import varied_lights
from shading_model.errors import RelightlabError
from shading_model.illumination import C2, LogHarmonics
from tests.reports.html_outline import read_html
from tests.reports.small_result import OBJECTS, SmallResult, small_result

__all__ = ["small_result"]
FROM_THE_RIGHT = LogHarmonics(np.eye(9)[3] / (2 * C2))


def decoded(source: str) -> np.ndarray:
    """Return the pixels of a data address."""
    header, content = source.split(",", 1)
    assert header == "data:image/webp;base64"
    with PillowImage.open(io.BytesIO(base64.b64decode(content))) as picture:
        return np.asarray(picture.convert("RGBA"))


@given(value=st.floats(0.0, 1.0), factor=st.floats(0.1, 10.0))
def test_photographs_are_encoded_for_a_screen(value: float, factor: float) -> None:
    """A linear value is brightened, clipped and encoded, and decodes to itself within a step."""
    shown = photograph_picture(np.full((1, 1, 3), value), factor)[0, 0, 0] / 255
    back = shown / 12.92 if shown <= 0.04045 else ((shown + 0.055) / 1.055) ** 2.4
    assert back == pytest.approx(min(value * factor, 1.0), abs=0.005)


def test_background_is_transparent_and_black() -> None:
    """Where a map is NaN its picture is transparent, whatever the kind of map."""
    scalar = np.array([[0.5, np.nan]])
    colour = np.repeat(scalar[..., None], 3, axis=-1)
    for picture in (
        photograph_picture(scalar),
        photograph_picture(colour),
        diverging_picture(scalar, 1.0),
        normal_picture(colour),
    ):
        assert picture[0, 0, 3] == 255
        assert picture[0, 1].tolist() == [0, 0, 0, 0]


def test_exposure_of_nothing_is_one() -> None:
    """A black or an empty picture is not brightened."""
    assert exposure(np.zeros((2, 2))) == 1.0
    assert exposure(np.full((2, 2), np.nan)) == 1.0


def test_diverging_colours_are_the_scale_shown() -> None:
    """Minus the limit, zero and plus the limit have the colours at the scale's ends and middle."""
    picture = diverging_picture(np.array([[-9.0, -0.2, 0.0, 0.2, 9.0]]), 0.2)
    low, middle, high = diverging_stops(3)
    shown = ["#" + bytes(pixel[:3].tolist()).hex() for pixel in picture[0]]
    assert shown == [low, low, middle, high, high]


@given(st.floats(1e-6, 1e6))
def test_limits_are_round_and_not_below_the_values(value: float) -> None:
    """A scale's limit has one digit and is less than twice the largest value above it."""
    limit = symmetric_limit(np.array([[-value, np.nan]]))
    assert value <= limit * (1 + 1e-9)
    assert limit <= 2 * value * (1 + 1e-9)
    assert len(f"{limit:.6e}".split("e")[0].rstrip("0").rstrip(".")) == 1


def test_limit_of_zero_maps_is_one() -> None:
    """A map of zeros still has a scale."""
    assert symmetric_limit(np.zeros((2, 2))) == 1.0


def test_sphere_is_bright_toward_the_light() -> None:
    """A sphere lit from the right is brighter right than left, and equal above and below."""
    sphere = sphere_picture(FROM_THE_RIGHT, 41, 61)[..., 0].astype(int)
    assert sphere[20, 42] > sphere[20, 30] > sphere[20, 18] > 0
    assert np.array_equal(sphere, sphere[::-1])
    assert sphere[20, 2] == 0


def test_light_is_set_into_the_emptiest_corner() -> None:
    """The sphere covers no pixel of an object that leaves a corner free, and changes no other."""
    picture = np.full((40, 60, 4), 255, dtype=np.uint8)
    picture[28:, 48:] = 0
    shown = with_light(picture, FROM_THE_RIGHT)
    assert (shown[28:, 48:, 3] > 0).any()
    shown[28:, 48:] = 0
    assert np.array_equal(shown, picture)


def test_pictures_are_made_smaller_but_never_larger() -> None:
    """A wide picture is reduced in proportion, a narrow one left alone."""
    assert fitted(np.zeros((100, 520, 4), np.uint8), 260).shape == (50, 260, 4)
    assert fitted(np.zeros((100, 50, 4), np.uint8), 260).shape == (100, 50, 4)


def test_data_address_holds_the_picture() -> None:
    """A picture survives its address: opacity exactly, colours nearly."""
    picture = photograph_picture(np.linspace(0, 1, 64).reshape(8, 8), 1.0)
    picture[:, :2] = 0
    back = decoded(data_uri(picture))
    assert np.array_equal(back[..., 3], picture[..., 3])
    inside = picture[..., 3] > 0
    assert np.abs(back[inside].astype(int) - picture[inside].astype(int)).mean() < 8


def test_panel_without_description_is_refused() -> None:
    """A picture that is not described does not get onto a page."""
    with pytest.raises(RelightlabError, match="expected a description"):
        panel(np.zeros((2, 2, 4), np.uint8), "", "caption")


@given(st.integers(1, 8))
def test_varied_lights_are_distinct(count: int) -> None:
    """As many lights as asked for, none twice, and a longer choice begins with the shorter."""
    generator = np.random.default_rng(count)
    lights = [LogHarmonics(c) for c in generator.normal(size=(8, 9))]
    chosen = varied_lights(lights, count)
    assert len(set(chosen)) == len(chosen) == count
    assert varied_lights(lights, 8)[:count] == chosen


def test_decomposition_shows_two_objects(small_result: SmallResult) -> None:
    """Two objects have eight layers and four other lights each, and the layers add up."""
    figure = decomposition_figure(small_result.subject())
    assert [len(row.panels) for row in figure.rows] == [8, 4, 8, 4]
    assert [len(row.scales) for row in figure.rows] == [2, 0, 2, 0]
    again = figure.rows[0].panels[7]
    assert again.caption == "A (coarse + S_p)"
    assert again.note == "equal to I"


def test_light_fits_show_both_residuals(small_result: SmallResult) -> None:
    """The residuals shown below each fit are those of the result's table."""
    subject = small_result.subject()
    figure = light_fit_figure(subject)
    table = {
        row["object"]: row
        for row in subject.document["intrinsic"]
        if row["setting"] == "laboratory"
    }
    assert len(figure.rows) == len(OBJECTS)
    for row in figure.rows:
        own = table[row.title]
        assert row.panels[3].note == f"rms {own['harmonic_residual']:.3f}"
        assert row.panels[4].note == f"rms {own['point_light_residual']:.3f}"


def test_gallery_spans_the_errors(small_result: SmallResult) -> None:
    """The gallery starts with the object of least error and ends with that of most."""
    subject = small_result.subject()
    errors = {
        row["object"]: row["relative_imse"]
        for row in subject.document["objects"]
        if (row["setting"], row["detail_source"], row["weights"])
        == ("natural", "default", "oracle")
    }
    assert spread_over_errors(subject, "natural", 2) == (
        min(errors, key=lambda name: errors[name]),
        max(errors, key=lambda name: errors[name]),
    )
    figure = gallery_figure(subject, "natural")
    assert [len(row.panels) for row in figure.rows] == [6] * 2 * len(OBJECTS)


def test_oracle_pictures_have_the_smaller_error(small_result: SmallResult) -> None:
    """In every row of the gallery the oracle's share of error is at most the default's."""
    for row in gallery_figure(small_result.subject(), "laboratory").rows:
        oracle, default = (float(row.panels[place].note.split()[0]) for place in (3, 5))
        assert oracle <= default


def test_best_scale_is_that_of_least_squares() -> None:
    """The scaled image is no nearer to the target for any other scale, and never negative."""
    generator = np.random.default_rng(3)
    image, target = generator.uniform(size=(2, 5, 5, 3))
    best = best_scaled(image, target)
    factor = float(np.nanmean(best / image))

    def error(scale: float) -> float:
        return float((((scale * image) - target).mean(axis=-1) ** 2).sum())

    assert error(factor) < min(error(factor * 0.99), error(factor * 1.01))
    assert np.array_equal(best_scaled(-image, target), np.zeros_like(image))


def test_plots_name_every_object_and_entry(small_result: SmallResult) -> None:
    """The plots hold each object and each comparable entry as text, not as outlines."""
    subject = small_result.subject()
    objects, shape = object_error_figure(subject), table_shape_figure(subject)
    texts = [element.text for element in read_html(objects.svg).all("text")]
    assert set(OBJECTS) | {"natural", "laboratory", "coarse", "oracle"} <= set(texts)
    assert "laboratory, (c) GT S, oracle" in read_html(shape.svg).text
    assert "natural, (a) default, regression: published 1.00, here 1.00" in shape.description


def test_plots_bear_missing_values(small_result: SmallResult) -> None:
    """A result without any value still gives its plots."""
    document = small_result.document
    nothing = {"imse": None, "relative_imse": None}
    subject = small_result.subject(
        rows=[row | nothing for row in document["rows"]],
        objects=[row | nothing for row in document["objects"]],
    )
    assert "<svg" in object_error_figure(subject).svg
    assert "here not measured" in table_shape_figure(subject).description


def test_plots_follow_the_page() -> None:
    """Drawn twice a plot is the same text; it has no date, address or clashing identifier."""

    def drawn(identifier: str) -> str:
        with plot_style():
            figure = Figure()
            figure.subplots().plot([0, 1], [0, 1], "o")
            return page_svg(figure, identifier)

    first, other = drawn("first"), drawn("other")
    assert first == drawn("first")
    assert "currentColor" in first
    assert "://" not in first
    identifiers = [
        {e.attributes["id"] for e in read_html(svg).all() if "id" in e.attributes}
        for svg in (first, other)
    ]
    assert identifiers[0]
    assert not identifiers[0] & identifiers[1]


def test_panels_are_stored_at_display_size(small_result: SmallResult) -> None:
    """No picture of a page is wider than it is shown, and each decodes to its stated size."""
    figures: list[PanelFigure] = [decomposition_figure(small_result.subject())]
    for shown in (shown for figure in figures for row in figure.rows for shown in row.panels):
        assert shown.width <= DISPLAY_WIDTH
        assert decoded(shown.source).shape == (shown.height, shown.width, 4)


def test_readme_picture_is_repeatable(small_result: SmallResult, tmp_path: Path) -> None:
    """The README's picture is the same twice, with a row for each object."""
    paths = [tmp_path / "one.png", tmp_path / "two.png"]
    for path in paths:
        write_readme_picture(path, small_result.dataset, small_result.parameters, OBJECTS[:2])
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with PillowImage.open(paths[0]) as picture:
        assert picture.mode == "RGB"
        assert picture.size[0] == 1197
        assert picture.size[1] == pytest.approx(372, abs=1)


def test_readme_picture_refuses_a_bad_place(small_result: SmallResult, tmp_path: Path) -> None:
    """An unwritable place or an unknown object is one sentence."""
    (tmp_path / "file").write_text("taken", encoding="utf-8")
    data, parameters = small_result.dataset, small_result.parameters
    with pytest.raises(RelightlabError, match="cannot write"):
        write_readme_picture(tmp_path / "file" / "a.png", data, parameters, OBJECTS[:1])
    with pytest.raises(RelightlabError, match="unicorn"):
        write_readme_picture(tmp_path / "a.png", data, parameters, ["unicorn"])


def test_readme_picture_is_made_by_one_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The command makes its own objects, and the picture has the size of the committed one."""
    small = partial(synthesize, size=64, samples=2, workers=1)
    monkeypatch.setattr("reports.readme_picture.synthesize", small)
    main([str(tmp_path / "relit.png")])
    committed = Path(__file__).resolve().parents[2] / "docs" / "relit.png"
    assert committed.stat().st_size < 400_000
    with PillowImage.open(tmp_path / "relit.png") as made, PillowImage.open(committed) as kept:
        assert made.size == kept.size


def test_lamps_have_their_colour_at_the_terminator() -> None:
    """Across the light's direction the shading is its colour, toward it e^contrast of it."""
    light = lamp((2.0, 0.0, 0.0), (0.2, 0.4, 0.6))
    across, toward = light.shade(np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]))
    assert across == pytest.approx(np.array([0.2, 0.4, 0.6]))
    assert toward == pytest.approx(across * np.exp(CONTRAST))
