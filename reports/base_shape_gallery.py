"""Pictures of the study of base shapes: relightings beside the photographs, and the lights."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cache

import numpy as np
from threadpoolctl import threadpool_limits

from datasets.records import LitPhotograph
from evaluation.base_shape_models import StudyBuild, study_builds
from evaluation.photograph_cells import photograph_cell, relit_as_photographed
from reports.base_shape_run import BaseShapeStudy
from reports.base_shape_words import Document, key_of, measured_shapes, set_words, short_words
from reports.figures import Panel, PanelFigure, PanelRow, Scale, panel
from reports.gallery_figure import best_scaled
from reports.pictures import (
    Picture,
    diverging_picture,
    exposure,
    photograph_picture,
    sphere_picture,
    symmetric_limit,
)
from reports.subject import varied_lights
from shading_model.arrays import Image
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics

Built = Callable[[str], StudyBuild]
"""Object to what its models are built from."""
OBJECTS, SHAPES = 3, 5
SHOWN_OBJECTS, ABREAST = 5, (5, 6)
SPHERE_SIDE = 0.6
"""Of the width of a photograph, the height of the picture of its light."""


def picture_figures(
    study: BaseShapeStudy, words: Mapping[str, str]
) -> tuple[PanelFigure, PanelFigure]:
    """Return the gallery of a study, and its photographs and lights; each object is built once.

    Parameters
    ----------
    study : BaseShapeStudy
    words : mapping of str
        What the shapes are called.

    Returns
    -------
    PanelFigure, PanelFigure
        See `shape_gallery` and `lights_figure`.
    """

    @cache
    def built(name: str) -> StudyBuild:
        variant = study.document["protocol"]["variant"]
        return study_builds(study.context, name, variant)[0]

    with threadpool_limits(limits=1):  # as the cells were measured, and faster on small matrices
        return shape_gallery(study.document, words, built), lights_figure(study.document, built)


def shape_gallery(document: Document, words: Mapping[str, str], built: Built) -> PanelFigure:
    """Return photographs under a light with the relightings of models on several base shapes.

    Parameters
    ----------
    document : mapping
    words : mapping of str
        What the shapes are called.
    built : callable
        Gives what the models of an object are built from.

    Returns
    -------
    PanelFigure
        A shape that cannot be made of an object is left out of its row.
    """
    names = spread_over_errors(document, OBJECTS)
    shapes = measured_shapes(document)[:SHAPES]
    called = short_words(words)
    rows = tuple(_row(built(name), place, shapes, called) for place, name in enumerate(names))
    return PanelFigure(
        f"base-shape-gallery-{key_of(document)}",
        f"Relit on each base shape: {set_words(document['provenance']['dataset'])}",
        "Each object as it was photographed under one of its lights, and relit as its models see"
        " it, which differ only in their base shape; below, the light on a white sphere and the"
        " errors, relit - photograph, mean over colour channels. Objects are not hand-picked: they"
        " are spread evenly from the lowest to the highest relative error of the contour shape with"
        " oracle weights, and lights differ much. Weights are each model's oracle weights. Relit"
        " pictures are scaled by the best k and share the photograph's exposure.",
        rows,
    )


def lights_figure(document: Document, built: Built) -> PanelFigure:
    """Return objects of a set, and the photographs of one with their lights (`fig:dataset`).

    Parameters
    ----------
    document : mapping
    built : callable
        As for `shape_gallery`.

    Returns
    -------
    PanelFigure
    """
    names = list(dict.fromkeys(row["object"] for row in document["objects"]))
    name = spread_over_errors(document, 1)[0]
    places = np.linspace(0, len(names) - 1, min(SHOWN_OBJECTS, len(names))).round().astype(int)
    objects = tuple(_object_panel(built(names[place])) for place in places)
    lit = built(name).lit
    lights = tuple(_light_panel(one, number) for number, one in enumerate(lit, start=1))
    title = set_words(document["provenance"]["dataset"])
    return PanelFigure(
        f"lights-{key_of(document)}",
        f"The photographs and their lights: {title}",
        "After the paper's `fig:dataset`. Objects as their models are built from them, where there"
        f" are several, and every photograph of {name} with the light it is relit with, on a white"
        " sphere. Pictures have exposures of their own.",
        (
            *([PanelRow("Objects", objects, ABREAST[0])] if len(objects) > 1 else []),
            PanelRow(f"{name} under {len(lit)} lights", lights, _abreast(len(lit))),
        ),
    )


def spread_over_errors(document: Document, count: int) -> tuple[str, ...]:
    """Return objects spread evenly by rank of the relative oracle error of the first shape.

    Parameters
    ----------
    document : mapping
    count : int

    Returns
    -------
    tuple of str
        Lowest error first, unknown ones last; at most as many as were measured. One is the
        median.

    Examples
    --------
    >>> rows = [{"object": name, "shape": "contour", "weights": "oracle", "relative_imse": error}
    ...         for name, error in (("cat", 0.3), ("owl", 0.1), ("horse", 0.2))]
    >>> document = {"objects": rows, "rows": rows}
    >>> spread_over_errors(document, 2), spread_over_errors(document, 1)
    (('owl', 'cat'), ('horse',))
    """
    (shape, *_) = measured_shapes(document)
    errors = {
        row["object"]: np.inf if row["relative_imse"] is None else row["relative_imse"]
        for row in document["objects"]
        if (row["shape"], row["weights"]) == (shape, "oracle")
    }
    ranked = sorted(errors, key=lambda name: (errors[name], name))
    last = len(ranked) - 1
    places = np.linspace(0, last, min(count, len(ranked))) if count > 1 else np.array([last / 2])
    return tuple(ranked[place] for place in places.round().astype(int))


def _row(
    build: StudyBuild, place: int, shapes: Sequence[str], words: Mapping[str, str]
) -> PanelRow:
    name = build.name
    lights = [build.lit[index].illumination.monochrome() for index in build.images.lights]
    chosen = varied_lights(lights, OBJECTS)
    number = build.images.lights[chosen[place % len(chosen)]]
    light, title = build.lit[number], f"light {number + 1}"
    target = np.where(build.mask[..., None], light.photograph.image, np.nan)
    relit, shares = _relit(build, shapes, light, target)
    errors = {shape: (image - target).mean(axis=-1) for shape, image in relit.items()}
    limit, bright = symmetric_limit(*errors.values()), exposure(target)
    sphere = sphere_picture(light.illumination, *build.mask.shape)
    above, below = (
        [panel(photograph_picture(target, bright), f"{name} under {title}", "photograph")],
        [panel(sphere, f"White sphere under {title}", title)],
    )
    for shape, image in relit.items():
        seen = photograph_picture(image, bright)
        where = f"{name} under {title} on the shape {words[shape]}"
        above.append(panel(seen, f"Relit: {where}", words[shape], f"{100 * shares[shape]:.1f} %"))
        below.append(
            panel(
                diverging_picture(errors[shape], limit),
                f"Error: {where}, orange too dark, purple too bright",
                "error",
                words[shape],
            )
        )
    return PanelRow(f"{name}, {title}", (*above, *below), len(above), (Scale(limit, "error"),))


def _relit(
    build: StudyBuild, shapes: Sequence[str], light: LitPhotograph, target: Image
) -> tuple[dict[str, Image], dict[str, float]]:
    """Return relit pictures at their best scale and their relative errors, by shape."""
    relit: dict[str, Image] = {}
    shares: dict[str, float] = {}
    lamp = build.variant.light(light.illumination)
    for shape in shapes:
        with suppress(RelightlabError):  # the table says which shapes failed, and why
            model = build.model(build.shape(shape))
            cell = photograph_cell(
                *(model, light.photograph.image, lamp, build.context.channels),
                match_exposure=build.variant.match_exposure,
            )
            weights = cell.oracle()
            image = relit_as_photographed(
                model, lamp, weights, match_exposure=build.variant.match_exposure
            )
            relit[shape] = best_scaled(image, target)
            shares[shape] = cell.error(weights) / cell.power
    return relit, shares


def _abreast(count: int) -> int:
    """Return how many pictures of equal rank stand side by side: no odd ones in the last line."""
    return next((columns for columns in ABREAST if count % columns == 0), ABREAST[0])


def _object_panel(build: StudyBuild) -> Panel:
    image = np.where(build.mask[..., None], build.images.image, np.nan)
    return panel(
        photograph_picture(image), f"{build.name}, as its models are built from it", build.name
    )


def _light_panel(lit: LitPhotograph, number: int) -> Panel:
    photograph = lit.photograph
    image = np.where(photograph.mask[..., None], photograph.image, np.nan)
    shown = above_sphere(photograph_picture(image), lit.illumination)
    words = f"{photograph.name} under light {number}, and a white sphere under it"
    return panel(shown, words, f"light {number}")


def above_sphere(picture: Picture, light: LogHarmonics) -> Picture:
    """Return a picture with a white sphere under a light set below it.

    Parameters
    ----------
    picture : (h, w, 4) uint8 array
    light : LogHarmonics

    Returns
    -------
    (h', w, 4) uint8 array

    Examples
    --------
    >>> above_sphere(np.zeros((10, 10, 4), np.uint8), LogHarmonics(np.zeros(9))).shape
    (16, 10, 4)
    """
    width = picture.shape[1]
    side = max(1, round(SPHERE_SIDE * width))
    return np.concatenate([picture, sphere_picture(light, side, width)])
