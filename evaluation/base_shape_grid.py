"""Table 2 as a grid: a cell is an object relit by a model on one base shape, under one light.

The target is the photograph that was really taken under that light (`subsec:shapestudy`). Values
are inner products, as in Table 1, so that every weight rule is evaluated on the rows alone, and
the light's coefficients, which the regression of weights needs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from threadpoolctl import threadpool_limits

from datasets.records import Dataset
from evaluation.base_shape_models import BaseShapeContext, StudyBuild, study_builds
from evaluation.base_shapes import BASE_SHAPES, FITTED_SHAPES, HasSensor
from evaluation.cell_values import cell_values
from evaluation.experiment import Cell, Experiment, Values
from evaluation.input_hashes import parameters_hash, shared_inputs
from evaluation.photograph_cells import photograph_cell
from evaluation.sirfs_fits import priors_in_use
from evaluation.study_variants import TABLE, VARIANTS
from shading_model.errors import RelightlabError, unknown_name
from shading_model.object_model import CoarseShape

NAME, VERSION = "base-shapes", 1
LIGHT_VALUES = tuple(f"light_{number}" for number in range(9))


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
    wanted: dict[str, dict[int, Cell]] = {}
    for cell in cells:
        wanted.setdefault(cell["shape"], {})[int(cell["light"])] = cell
    with threadpool_limits(limits=1):
        builds = study_builds(context, cells[0]["object"], cells[0]["variant"])
        # Fits come last, so that one that fails leaves the other shapes their results.
        for shape in sorted(wanted, key=lambda name: name in FITTED_SHAPES):
            yield from _measure_shape(shape, wanted[shape], builds)


def _measure_shape(
    name: str, places: Mapping[int, Cell], builds: Sequence[StudyBuild]
) -> Iterator[tuple[Cell, Values]]:
    shape: CoarseShape | None = None
    for build in builds:
        lights = [light for light in build.images.lights if light in places]
        if not lights:
            continue
        if shape is None or name in FITTED_SHAPES:
            shape = build.shape(name)
        model = build.model(shape)
        for light in lights:
            known = build.lit[light].illumination
            cell = photograph_cell(
                model,
                build.lit[light].photograph.image,
                build.variant.light(known),
                build.context.channels,
                match_exposure=build.variant.match_exposure,
            )
            coefficients = known.monochrome().coefficients.tolist()
            lamp = dict(zip(LIGHT_VALUES, coefficients, strict=True))
            yield places[light], {**cell_values(cell), **lamp}


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
