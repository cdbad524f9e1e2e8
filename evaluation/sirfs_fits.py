"""SIRFS fitted to the photographs of a dataset, each once: fits are kept in a blob store.

A fit's key is a hash of all that it depends on: the photograph, its mask and outline, the options,
the priors and the code. So a change of lights, of error measures or of reports, or a run that was
interrupted, leaves the fits valid.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from datasets.records import Dataset
from evaluation.blob_store import BLOBS, BlobStore, blob_key
from evaluation.code_version import code_hash
from evaluation.sirfs.fit import FitOptions, fit_sirfs_stereo
from evaluation.sirfs.fit_files import SUFFIX, load_fit, save_fit
from evaluation.sirfs.prior_files import shipped_priors
from evaluation.sirfs.priors import SirfsPriors, priors_identity
from evaluation.sirfs.result import SirfsFit
from shading_model.arrays import Image, Mask

FITTING_CODE = (
    *("evaluation/sirfs", "shading_model/illumination.py"),
    "shading_model/height_field.py",
)
"""The code that a fit depends on."""
OUTLINE_SETTING = "laboratory"


@dataclass(frozen=True)
class SirfsFits:
    """Fits by the shipped priors, shared by processes on one machine where they have a folder.

    Parameters
    ----------
    folder : Path, optional
        See `evaluation.blob_store.BlobStore`; without one, every fit is made when it is asked for.
    without : tuple of str
        Terms of the loss that are left out: an ablation.
    """

    folder: Path | None = None
    without: tuple[str, ...] = ()

    @classmethod
    def in_store(cls, store: Path | None, without: Sequence[str] = ()) -> SirfsFits:
        """Return fits that are kept among the blobs of a store, where there is one.

        Parameters
        ----------
        store : Path, optional
            Its folder.
        without : sequence of str

        Examples
        --------
        >>> SirfsFits.in_store(None) == SirfsFits()
        True
        """
        return cls(None if store is None else store / BLOBS, tuple(without))

    def fit(self, dataset: Dataset, name: str, setting: str, channels: str = "color") -> SirfsFit:
        """Return the fit to an object's photograph in one setting, made or read: the same bits.

        Parameters
        ----------
        dataset : Dataset
        name, setting : str
            The light model is that of the setting's name, see `light_model`.
        channels : {"color", "gray"}

        Raises
        ------
        RelightlabError
            If the photograph cannot be loaded or fitted, or the folder cannot be written.
        """
        photograph = dataset.load(name, setting).photograph
        outline = object_outline(dataset, name, setting)
        options = FitOptions(light_model(setting), channels, self.without)
        return self.fit_images([photograph.image], photograph.mask, options, outline)

    def fit_images(
        self,
        images: Sequence[Image],
        mask: Mask,
        options: FitOptions,
        outline: Mask | None = None,
    ) -> SirfsFit:
        """Return the fit to photographs that share one shape, made or read: the same bits.

        Parameters
        ----------
        images : sequence of (h, w, 3) arrays
            One photograph, or several from one place under different lights (SIRFS-stereo).
        mask : (h, w) bool array
        options : FitOptions
            Without a known shape, a known light or a depth map, which have no part in the key.
        outline : (h, w) bool array, optional
            The object's silhouette, where the mask is less than it.

        Returns
        -------
        SirfsFit
            Albedo, shading and light are those of the first photograph.

        Raises
        ------
        RelightlabError
            As `evaluation.sirfs.fit.fit_sirfs_stereo`, or if the folder cannot be written.
        """
        priors, identity = priors_in_use()
        silhouette = mask if outline is None else outline

        def make() -> SirfsFit:
            with threadpool_limits(limits=1):
                return fit_sirfs_stereo(images, mask, priors, options, outline=silhouette)[0]

        if self.folder is None:
            return make()
        key = fit_key(images, mask, silhouette, options, identity)
        return BlobStore(self.folder, SUFFIX).get_or_make(key, make, load_fit, save_fit)


UNKEPT = SirfsFits()
"""Fits that are made whenever they are needed."""


@cache
def priors_in_use() -> tuple[SirfsPriors, str]:
    """Return the priors of every fit, and what identifies them: the shipped ones.

    Returns
    -------
    SirfsPriors, str
    """
    priors = shipped_priors()
    return priors, priors_identity(priors)


def light_model(setting: str) -> str:
    """Return which lights are likely in a setting: its own where there is a model of it.

    Parameters
    ----------
    setting : str

    Returns
    -------
    {"natural", "laboratory"}

    Examples
    --------
    >>> light_model("natural"), light_model("photograph")
    ('natural', 'laboratory')
    """
    return "natural" if setting == "natural" else "laboratory"


def object_outline(dataset: Dataset, name: str, setting: str) -> Mask:
    """Return where an object ends, as opposed to where its photograph is known.

    A natural photograph of MIT-Berkeley is blank where the depth is not known, which is no
    contour of the object; its laboratory photograph shows the object whole.

    Parameters
    ----------
    dataset : Dataset
    name, setting : str

    Returns
    -------
    (h, w) bool array
        The mask of the laboratory photograph where there is one of the same size, else the mask.
    """
    mask = dataset.load(name, setting).photograph.mask
    if setting == OUTLINE_SETTING or OUTLINE_SETTING not in dataset.settings:
        return mask
    whole = dataset.load(name, OUTLINE_SETTING).photograph.mask
    return whole if whole.shape == mask.shape else mask


def fit_key(
    images: Sequence[Image], mask: Mask, outline: Mask, options: FitOptions, priors: str
) -> str:
    """Return the key of the fit to these inputs by this code.

    Parameters
    ----------
    images : sequence of (h, w, 3) arrays
    mask : (h, w) bool array
    outline : (h, w) bool array
    options : FitOptions
        Of them, the light model, the channels, the terms left out and the evaluations.
    priors : str
        See `evaluation.sirfs.priors.priors_identity`.

    Returns
    -------
    str
    """
    inputs = {
        "image": " ".join(_hash(image) for image in images),
        "mask": _hash(mask),
        "outline": _hash(outline),
        "priors": priors,
    }
    parameters = {
        "light": options.light,
        "channels": options.channels,
        "without": " ".join(sorted(options.without)),
        "evaluations": repr(options.evaluations),
    }
    return blob_key(inputs, parameters, code_hash(FITTING_CODE))


def _hash(array: Any) -> str:
    digest = hashlib.sha256(f"{array.dtype} {array.shape}".encode())
    digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
