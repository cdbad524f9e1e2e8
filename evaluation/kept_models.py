"""Object models kept in a blob store, so that they are built once however often they are measured.

A model's key is a hash of what it is built from: the photograph, its mask, its albedo and shading,
the parameters and parts of the model, and the code that builds it. So a change of lights, of error
measures or of reports leaves the kept models valid.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from datasets.model_files import SUFFIX, load_model, save_model
from datasets.records import Photograph
from evaluation.blob_store import BlobStore, blob_key
from evaluation.code_version import code_hash
from evaluation.model_parts import ModelParts
from shading_model.object_model import ModelParameters, ObjectModel
from shading_model.retinex import IntrinsicImages

BUILDING_CODE = ("shading_model", "datasets", "evaluation/model_parts.py")
"""The code that a model depends on."""


@dataclass(frozen=True)
class KeptModels:
    """A folder of object models, shared by processes on one machine.

    Parameters
    ----------
    folder : Path
        See `evaluation.blob_store.BlobStore`.
    """

    folder: Path

    def get_or_build(
        self,
        photograph: Photograph,
        images: IntrinsicImages,
        parameters: ModelParameters,
        parts: ModelParts,
        build: Callable[[], ObjectModel],
    ) -> ObjectModel:
        """Return the kept model of these inputs, or build and keep it; the bits are the same.

        Raises
        ------
        RelightlabError
            If the folder cannot be written, or as `build`.
        """
        key = model_key(photograph, images, parameters, parts)

        def write(path: Path, model: ObjectModel) -> None:
            save_model(path, model, name=photograph.name, source=photograph.source)

        return BlobStore(self.folder, SUFFIX).get_or_make(key, build, load_model, write)


def model_key(
    photograph: Photograph, images: IntrinsicImages, parameters: ModelParameters, parts: ModelParts
) -> str:
    """Return the key of the model built from these inputs by this code.

    Parameters
    ----------
    photograph : Photograph
    images : IntrinsicImages
        Its albedo and shading.
    parameters : ModelParameters
    parts : ModelParts

    Returns
    -------
    str
    """
    inputs = {
        "name": photograph.name,
        "source": photograph.source,
        "image": _hash(photograph.image),
        "mask": _hash(photograph.mask),
        "albedo": _hash(images.albedo),
        "shading": _hash(images.shading),
    }
    settings = {
        "slope limit": repr(parameters.slope_limit),
        "sparsity": repr(parameters.sparsity),
        "dictionary": _hash(parameters.dictionary.atoms),
        "parts": parts.identity,
    }
    return blob_key(inputs, settings, code_hash(BUILDING_CODE))


def _hash(array: Any) -> str:
    digest = hashlib.sha256(f"{array.dtype} {array.shape}".encode())
    digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
