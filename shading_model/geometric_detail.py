"""Geometric detail S_g: what a dictionary of smooth shading patches cannot explain.

Overlapping patches of the shading are rebuilt from a dictionary learned on smooth shadings with an
L1 penalty on the coefficients (Liao et al. 2013); the residual is fine-scale detail. All patches
are coded at once by accelerated proximal gradient (FISTA) in the few dimensions that the
dictionary spans, so the work is matrix products and grows linearly with the number of pixels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, map_coordinates

from shading_model.arrays import Float, Map, Mask, check_map, check_mask
from shading_model.errors import RelightlabError

REFERENCE_SIDE = 600
"""Objects of this many pixels are filtered with patches of the dictionary's own size."""
SMALLEST_PATCH = 4
STRIDES_PER_PATCH = 3
SPARSITY = 0.3
"""Weight of the L1 penalty for a shading of mean 0.5 and atoms of unit norm; chosen by eye."""
ITERATIONS = 12
SPANNED_ENERGY = 1e-3
"""Directions with less than this share of the strongest one's energy are left out."""
CHUNK = 256
"""Patches coded together: bounds the memory and keeps the coefficients in the cache's reach."""


@dataclass(frozen=True, eq=False)
class PatchDictionary:
    """Atoms of unit norm and mean zero.

    Parameters
    ----------
    atoms : (k, p, p) array

    Raises
    ------
    RelightlabError
        If the array has another shape or an atom is not finite.
    """

    atoms: Float

    def __post_init__(self) -> None:
        if self.atoms.ndim != 3 or self.atoms.shape[1] != self.atoms.shape[2]:
            raise RelightlabError(f"expected atoms of shape (k, p, p), got {self.atoms.shape}")
        if not np.isfinite(self.atoms).all():
            raise RelightlabError("the dictionary's atoms contain NaN or infinite values")

    def resized(self, side: int) -> PatchDictionary:
        """Return the dictionary with atoms interpolated to side x side, again of unit norm."""
        count, own, _ = self.atoms.shape
        if side == own:
            return self
        centres = (np.arange(side) + 0.5) * own / side - 0.5
        rows, columns = np.meshgrid(centres, centres, indexing="ij")
        resized = np.stack(
            [map_coordinates(a, [rows, columns], order=1, mode="nearest") for a in self.atoms]
        )
        return PatchDictionary(unit_atoms(resized.reshape(count, -1)).reshape(count, side, side))


def unit_atoms(rows: Float) -> Float:
    """Return rows with their mean taken out, scaled to unit norm (zero rows stay zero).

    Examples
    --------
    >>> unit_atoms(np.array([[1.0, 3.0]])).round(3)
    array([[-0.707,  0.707]])
    """
    centred = rows - rows.mean(axis=1, keepdims=True)
    norm = np.linalg.norm(centred, axis=1, keepdims=True)
    scaled: Float = centred / np.where(norm > 0, norm, 1.0)
    return scaled


def geometric_detail(
    shading: Map,
    mask: Mask,
    dictionary: PatchDictionary,
    *,
    sparsity: float = SPARSITY,
) -> Map:
    """Return the geometric detail S_g = S - reconstruction of a shading.

    The patch size follows the longer side of the object's bounding box, the dictionary's own at
    `REFERENCE_SIDE` pixels, as the paper asks; patches overlap by about two thirds. Outside the
    mask the shading is continued with the value of the nearest pixel inside.

    Parameters
    ----------
    shading : (h, w) array
        Positive inside the mask; the result scales with it.
    mask : (h, w) bool array
    dictionary : PatchDictionary
    sparsity : float
        L1 weight, relative to twice the mean shading.

    Returns
    -------
    (h, w) array
        NaN outside the mask.

    Raises
    ------
    RelightlabError
        For an empty mask or a shading of another size.
    """
    inside = check_mask(mask)
    checked = check_map(shading, inside, "shading")
    box = _bounding_box(inside)
    side = patch_side(inside[box].shape)
    smooth = _reconstruct(checked[box], inside[box], dictionary.resized(side), sparsity)
    detail = np.full(inside.shape, np.nan)
    detail[box] = checked[box] - smooth
    return detail


def patch_side(shape: tuple[int, ...], reference_patch: int = 12) -> int:
    """Return the patch side for an object with this bounding box.

    Examples
    --------
    >>> patch_side((600, 400)), patch_side((1200, 800)), patch_side((20, 20))
    (12, 24, 4)
    """
    return max(SMALLEST_PATCH, round(reference_patch * max(shape) / REFERENCE_SIDE))


def _bounding_box(mask: Mask) -> tuple[slice, slice]:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def _reconstruct(shading: Map, mask: Mask, dictionary: PatchDictionary, sparsity: float) -> Map:
    side = dictionary.atoms.shape[1]
    stride = -(-side // STRIDES_PER_PATCH)
    scale = 2 * float(np.nanmean(shading))
    extended = _pad_to_patches(_continued(shading / scale, mask), side, stride)
    inside = _windows(_pad_to_patches(mask, side, stride, "constant"), side, stride)
    wanted: Mask = np.any(inside, axis=(2, 3))
    patches = _windows(extended, side, stride)[wanted].reshape(-1, side * side)
    rebuilt = code_patches(patches, dictionary, sparsity)
    total = _overlap_add(rebuilt, wanted, extended.shape, side, stride)
    count = _overlap_add(np.ones_like(rebuilt), wanted, extended.shape, side, stride)
    rows, columns = (slice(side, side + size) for size in shading.shape)
    return np.where(
        mask, scale * total[rows, columns] / np.maximum(count[rows, columns], 1), np.nan
    )


def code_patches(
    patches: Float, dictionary: PatchDictionary, sparsity: float, iterations: int = ITERATIONS
) -> Float:
    """Return the L1-regularised reconstruction of patches, each mean kept.

    Minimises ``|y - D a|^2 / 2 + sparsity |a|_1`` for each mean-free patch y.

    Parameters
    ----------
    patches : (n, p * p) array
    dictionary : PatchDictionary
        Of p x p atoms.
    sparsity : float
    iterations : int
        Steps of FISTA.

    Returns
    -------
    (n, p * p) array
    """
    atoms = dictionary.atoms.reshape(len(dictionary.atoms), -1)
    _, strength, directions = np.linalg.svd(atoms, full_matrices=False)
    kept = strength**2 > SPANNED_ENERGY * strength[0] ** 2
    span = directions[kept]
    compact = (atoms @ span.T).astype(np.float32)
    means = patches.mean(axis=1, keepdims=True)
    targets = ((patches - means) @ span.T).astype(np.float32)
    step = np.float32(1 / strength[0] ** 2)
    coded = [
        _sparse_code(targets[k : k + CHUNK], compact, step, np.float32(sparsity), iterations)
        for k in range(0, len(targets), CHUNK)
    ]
    rebuilt: Float = np.concatenate(coded).astype(np.float64) @ span + means
    return rebuilt


def _sparse_code(
    targets: NDArray[np.float32],
    atoms: NDArray[np.float32],
    step: np.float32,
    sparsity: np.float32,
    iterations: int,
) -> NDArray[np.float32]:
    """Run FISTA on targets (n, r) with atoms (k, r); return the coded targets, (n, r).

    Everything is updated in place: the arrays of one chunk stay in the processor's cache.
    """
    codes = np.zeros((len(targets), len(atoms)), np.float32)
    ahead, new, clipped = np.zeros_like(codes), np.empty_like(codes), np.empty_like(codes)
    descent = np.ascontiguousarray(step * atoms.T)
    limit = step * sparsity
    momentum = 1.0
    for _ in range(iterations):
        np.matmul(targets - ahead @ atoms, descent, out=new)
        new += ahead
        np.clip(new, -limit, limit, out=clipped)
        new -= clipped
        following = (1 + np.sqrt(1 + 4 * momentum**2)) / 2
        np.subtract(new, codes, out=ahead)
        ahead *= np.float32((momentum - 1) / following)
        ahead += new
        codes, new, momentum = new, codes, following
    return codes @ atoms


def _continued(values: Map, mask: Mask) -> Map:
    if mask.all():
        return values
    nearest = distance_transform_edt(~mask, return_distances=False, return_indices=True)
    continued: Map = values[tuple(nearest)]
    return continued


def _pad_to_patches(values: Float | Mask, side: int, stride: int, mode: str = "edge") -> Float:
    """Pad by one patch on each side, and so that the strides end exactly at the far edge."""
    widths = [(side, side + (-(size + side)) % stride) for size in values.shape]
    padded: Float = np.pad(values.astype(np.float64), widths, mode=mode)  # type: ignore[call-overload]
    return padded


def _windows(values: Float | Mask, side: int, stride: int) -> Float:
    windows: Float = np.lib.stride_tricks.sliding_window_view(values, (side, side))
    return windows[::stride, ::stride]


def _overlap_add(
    patches: Float, wanted: Mask, shape: tuple[int, ...], side: int, stride: int
) -> Float:
    grid = np.zeros((*wanted.shape, side, side))
    grid[wanted] = patches.reshape(-1, side, side)
    total = np.zeros(shape)
    for row in range(side):
        for column in range(side):
            target = total[row : row + stride * wanted.shape[0] : stride]
            target[:, column : column + stride * wanted.shape[1] : stride] += grid[..., row, column]
    return total
