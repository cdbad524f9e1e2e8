"""Table 2 as a grid: a cell is an object relit by a model on one base shape, under one light.

The target is the photograph that was really taken under that light (`subsec:shapestudy`). Values
are inner products, as in Table 1, so that every weight rule is evaluated on the rows alone, and
the light's coefficients, which the regression of weights needs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from threadpoolctl import threadpool_limits

from datasets.records import Capture, Dataset, LitPhotograph
from evaluation.base_shapes import (
    BASE_SHAPES,
    FITTED_SHAPES,
    HasSensor,
    ShapeRequest,
    steepened,
)
from evaluation.cell_values import cell_values
from evaluation.experiment import Cell, Experiment, Values
from evaluation.input_hashes import parameters_hash, shared_inputs
from evaluation.photograph_cells import photograph_cell
from evaluation.retinex_thresholds import thresholds_for
from evaluation.sirfs_fits import UNKEPT, SirfsFits, priors_in_use
from evaluation.study_variants import TABLE, VARIANTS, BuildImages, Variant
from shading_model.arrays import Map
from shading_model.errors import RelightlabError, unknown_name
from shading_model.geometric_detail import geometric_detail
from shading_model.object_model import CoarseShape, ModelParameters, assemble_model
from shading_model.retinex import IntrinsicImages, retinex

NAME, VERSION = "base-shapes", 1
SETTING = "laboratory"
"""The setting whose objects were photographed under several lights."""
LIGHT_VALUES = tuple(f"light_{number}" for number in range(9))


@dataclass(frozen=True, eq=False)
class BaseShapeContext:
    """What the cells of Table 2 are measured with.

    Parameters
    ----------
    dataset : Dataset
        With photographs under known lights, as many of every object.
    parameters : ModelParameters
    channels : {"gray", "color"}
    fits : SirfsFits
    """

    dataset: Dataset
    parameters: ModelParameters
    channels: str = "gray"
    fits: SirfsFits = UNKEPT


def base_shape_experiment(
    context: BaseShapeContext,
    variants: Sequence[str] = (TABLE,),
    shapes: Sequence[str] = (),
    objects: Sequence[str] = (),
    seed: str = "",
) -> Experiment:
    """Return the study of base shapes on a dataset as an experiment.

    Parameters
    ----------
    context : BaseShapeContext
    variants, shapes : sequence of str
        Of `available_variants` and `available_shapes`; the table alone, and all shapes, by default.
    objects : sequence of str
        All of the dataset by default.
    seed : str
        Plays no part: a sensor's noise is drawn by the names of dataset and object.

    Returns
    -------
    Experiment

    Raises
    ------
    RelightlabError
        For unknown names, a dataset without photographs under other lights, or objects of which
        there are not equally many.
    """
    dataset = context.dataset
    for kind, chosen, known in (
        ("variant", variants, available_variants(dataset)),
        ("base shape", shapes, available_shapes(dataset)),
        ("object", objects, dataset.objects),
    ):
        for name in chosen:
            if name not in known:
                raise unknown_name(kind, name, known)
    chosen_objects = tuple(name for name in dataset.objects if not objects or name in objects)
    count = _light_count(dataset, chosen_objects)
    return Experiment(
        name=NAME,
        version=VERSION,
        axes={
            "variant": tuple(name for name in VARIANTS if name in variants),
            "object": chosen_objects,
            "shape": tuple(
                name for name in available_shapes(dataset) if not shapes or name in shapes
            ),
            "light": tuple(f"{number:02d}" for number in range(count)),
        },
        together=("shape", "light"),
        measure=measure_base_shapes,
        context=context,
        inputs={
            **shared_inputs(dataset, (), context.channels),
            "parameters": parameters_hash(context.parameters),
            "priors": priors_in_use()[1],
        },
        seed=seed,
        cost_axis="shape",
    )


def available_variants(dataset: Dataset) -> tuple[str, ...]:
    """Return the variants that a dataset has the photographs for.

    Parameters
    ----------
    dataset : Dataset
        Without a diffuse photograph of its own it says ``has_diffuse_photograph = False``.

    Returns
    -------
    tuple of str
    """
    diffuse = getattr(dataset, "has_diffuse_photograph", True)
    return tuple(name for name, one in VARIANTS.items() if diffuse or not one.needs_diffuse)


def available_shapes(dataset: Dataset) -> tuple[str, ...]:
    """Return the base shapes that can be made of a dataset.

    Parameters
    ----------
    dataset : Dataset
        Where the true shape of its objects is not known, it says ``has_true_shape = False``.

    Returns
    -------
    tuple of str
    """
    known = getattr(dataset, "has_true_shape", True)
    needing = ("ground-truth",) if isinstance(dataset, HasSensor) else ("ground-truth", "kinect")
    return tuple(name for name in BASE_SHAPES if known or name not in needing)


def measure_base_shapes(
    context: BaseShapeContext, cells: Sequence[Cell]
) -> Iterator[tuple[Cell, Values]]:
    """Measure cells of one object in one variant.

    Parameters
    ----------
    context : BaseShapeContext
    cells : sequence of mappings

    Yields
    ------
    cell, values
    """
    variant = VARIANTS[cells[0]["variant"]]
    wanted: dict[str, dict[int, Cell]] = {}
    for cell in cells:
        wanted.setdefault(cell["shape"], {})[int(cell["light"])] = cell
    with threadpool_limits(limits=1):
        capture = context.dataset.load(cells[0]["object"], SETTING)
        lit = context.dataset.lit_photographs(cells[0]["object"])
        built = [
            (images, *_parts(images, capture, context)) for images in variant.build(capture, lit)
        ]
        # Fits come last, so that one that fails leaves the other shapes their results.
        for shape in sorted(wanted, key=lambda name: name in FITTED_SHAPES):
            yield from _measure_shape(shape, wanted[shape], built, variant, capture, lit, context)


def _measure_shape(
    name: str,
    places: Mapping[int, Cell],
    built: Sequence[tuple[BuildImages, IntrinsicImages, Map]],
    variant: Variant,
    capture: Capture,
    lit: Sequence[LitPhotograph],
    context: BaseShapeContext,
) -> Iterator[tuple[Cell, Values]]:
    shape: CoarseShape | None = None
    for images, parts, detail in built:
        lights = [light for light in images.lights if light in places]
        if not lights:
            continue
        if shape is None or name in FITTED_SHAPES:
            shape = _shape(name, images, variant, capture, context)
        mask = capture.photograph.mask
        model = assemble_model(mask, shape, parts, context.parameters, detail)
        for light in lights:
            known = lit[light].illumination
            cell = photograph_cell(
                model,
                lit[light].photograph.image,
                variant.light(known),
                context.channels,
                match_exposure=variant.match_exposure,
            )
            coefficients = known.monochrome().coefficients.tolist()
            lamp = dict(zip(LIGHT_VALUES, coefficients, strict=True))
            yield places[light], {**cell_values(cell), **lamp}


def _parts(
    images: BuildImages, capture: Capture, context: BaseShapeContext
) -> tuple[IntrinsicImages, Map]:
    """Return albedo, shading and geometric detail of a build image: the same for every shape."""
    mask, parameters = capture.photograph.mask, context.parameters
    name = capture.photograph.name
    thresholds = thresholds_for(context.dataset.name, SETTING, name) or parameters.thresholds
    parts = retinex(images.image, mask, thresholds)
    detail = geometric_detail(
        parts.shading, mask, parameters.dictionary, sparsity=parameters.sparsity
    )
    return parts, detail


def _shape(
    name: str, images: BuildImages, variant: Variant, capture: Capture, context: BaseShapeContext
) -> CoarseShape:
    shape = BASE_SHAPES[name](
        ShapeRequest(
            context.dataset,
            capture,
            images.image,
            images.photographs,
            context.parameters,
            context.fits,
        )
    )
    return shape if variant.height == 1.0 else steepened(shape, variant.height)


def _light_count(dataset: Dataset, objects: Sequence[str]) -> int:
    counts = {name: len(dataset.lit_photographs(name)) for name in objects}
    if not all(counts.values()):
        raise RelightlabError(
            f"{dataset.name} has no photographs of its objects under other lights: the study of"
            " base shapes needs them"
        )
    if len(set(counts.values())) > 1:
        listed = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise RelightlabError(
            f"expected equally many photographs under other lights of every object, got {listed}"
        )
    return next(iter(counts.values()))
