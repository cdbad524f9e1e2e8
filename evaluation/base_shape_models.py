"""The models of the study of base shapes: one object, one build image, and any base shape.

Albedo, shading and geometric detail are derived once for a build image and are the same for every
shape, so that models differ in their base shape alone (`subsec:shapestudy`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from datasets.records import Capture, Dataset, LitPhotograph
from evaluation.base_shapes import BASE_SHAPES, ShapeRequest, steepened
from evaluation.retinex_thresholds import thresholds_for
from evaluation.sirfs_fits import UNKEPT, SirfsFits
from evaluation.study_variants import TABLE, VARIANTS, BuildImages, Variant
from shading_model.arrays import Map, Mask
from shading_model.errors import unknown_name
from shading_model.geometric_detail import geometric_detail
from shading_model.object_model import CoarseShape, ModelParameters, ObjectModel, assemble_model
from shading_model.retinex import IntrinsicImages, retinex

SETTING = "laboratory"
"""The setting whose objects were photographed under several lights, where a set has it."""


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

    @property
    def setting(self) -> str:
        """The setting that models are built in: `SETTING`, else the set's first."""
        settings = self.dataset.settings
        return SETTING if SETTING in settings else settings[0]


@dataclass(frozen=True, eq=False)
class StudyBuild:
    """One object as built from one image, its base shape still open.

    Parameters
    ----------
    context : BaseShapeContext
    capture : Capture
    lit : tuple of LitPhotograph
        All photographs of the object under known lights.
    images : BuildImages
        What is built from, and the lights that it is tested under.
    variant : Variant
    """

    context: BaseShapeContext
    capture: Capture
    lit: tuple[LitPhotograph, ...]
    images: BuildImages
    variant: Variant

    @property
    def name(self) -> str:
        """Name of the object."""
        return self.capture.photograph.name

    @property
    def mask(self) -> Mask:
        """The object, (h, w)."""
        return self.capture.photograph.mask

    @cached_property
    def parts(self) -> IntrinsicImages:
        """Albedo and shading of the build image, by Retinex."""
        own = thresholds_for(self.context.dataset.name, SETTING, self.name)
        thresholds = own or self.context.parameters.thresholds
        return retinex(self.images.image, self.mask, thresholds)

    @cached_property
    def detail(self) -> Map:
        """Geometric detail of the build image, (h, w)."""
        parameters = self.context.parameters
        return geometric_detail(
            self.parts.shading, self.mask, parameters.dictionary, sparsity=parameters.sparsity
        )

    def shape(self, name: str) -> CoarseShape:
        """Return a base shape of the object.

        Parameters
        ----------
        name : str
            Of `evaluation.base_shapes.BASE_SHAPES`.

        Returns
        -------
        CoarseShape

        Raises
        ------
        RelightlabError
            If it is unknown, or cannot be made of this object.
        """
        if name not in BASE_SHAPES:
            raise unknown_name("base shape", name, BASE_SHAPES)
        context, images = self.context, self.images
        shape = BASE_SHAPES[name](
            ShapeRequest(
                context.dataset,
                self.capture,
                images.image,
                images.photographs,
                context.parameters,
                context.fits,
                self.variant.sensor,
            )
        )
        height = self.variant.height
        return shape if height == 1.0 else steepened(shape, height)

    def model(self, shape: CoarseShape) -> ObjectModel:
        """Return the model on a base shape; the rest of it is the same for all.

        Parameters
        ----------
        shape : CoarseShape
            As `shape` gives it.

        Returns
        -------
        ObjectModel
        """
        return assemble_model(self.mask, shape, self.parts, self.context.parameters, self.detail)


def study_builds(
    context: BaseShapeContext, name: str, variant: str = TABLE
) -> tuple[StudyBuild, ...]:
    """Return what an object's models are built from in one variant: together they serve all lights.

    Parameters
    ----------
    context : BaseShapeContext
    name : str
        An object of its dataset.
    variant : str
        Of `evaluation.study_variants.VARIANTS`.

    Returns
    -------
    tuple of StudyBuild

    Raises
    ------
    RelightlabError
        For unknown names, or an object without photographs under known lights.
    """
    if variant not in VARIANTS:
        raise unknown_name("variant", variant, VARIANTS)
    chosen = VARIANTS[variant]
    capture = context.dataset.load(name, context.setting)
    lit = tuple(context.dataset.lit_photographs(name))
    return tuple(
        StudyBuild(context, capture, lit, images, chosen) for images in chosen.build(capture, lit)
    )
