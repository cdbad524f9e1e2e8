"""Weights of the loss, for each kind of light and number of channels."""

from __future__ import annotations

from dataclasses import dataclass, replace

from shading_model.errors import RelightlabError, unknown_name

LIGHTS = ("natural", "laboratory")
CHANNELS = ("gray", "color")


@dataclass(frozen=True)
class TermWeights:
    """Weights of the terms of the loss (Barron and Malik's lambdas); zero leaves a term out.

    Parameters
    ----------
    curvature : float
        Smoothness of the shape: differences of mean curvature between neighbours.
    slant : float
        Isotropy of the shape: how far it leans away from the viewer.
    contour : float
        Normals on the outline point outward.
    albedo_smoothness : float
        Differences of log albedo between neighbours.
    albedo_entropy : float
        Parsimony: few values of log albedo.
    albedo_absolute : float
        How common a log albedo is.
    light : float
        The Gaussian of log-harmonic lights.
    depth : float
        Distance to an external depth map, where one is given.
    contour_power : float
        Exponent of the contour term.
    entropy_width : float
        Width of the kernel of the entropy, in twentieths of a unit of (whitened) log albedo.
    depth_power : float
        Exponent of the robust distance to an external depth map.
    """

    curvature: float
    slant: float
    contour: float
    albedo_smoothness: float
    albedo_entropy: float
    albedo_absolute: float
    light: float
    depth: float
    contour_power: float = 0.75
    entropy_width: float = 1.6818
    depth_power: float = 1.4142


TERMS = (
    *("curvature", "slant", "contour", "albedo_smoothness"),
    *("albedo_entropy", "albedo_absolute", "light", "depth"),
)
"""The weights that can be set to zero, one for each term of the loss."""

_WEIGHTS: dict[tuple[str, str], TermWeights] = {
    ("laboratory", "gray"): TermWeights(
        6.7272, 2.3784, 3.3636, 6.7272, 1.4142, 4.0, 4.7568, 8.0, depth_power=1.1892
    ),
    ("laboratory", "color"): TermWeights(
        6.7272, 2.3784, 4.0, 13.4543, 3.3636, 4.7568, 4.7568, 6.7272
    ),
    ("natural", "color"): TermWeights(
        4.7568, 1.0, 2.8284, 16.0, 3.3636, 4.7568, 3.3636, 2.0,
        entropy_width=2.8284, depth_power=0.8409,
    ),
}  # fmt: skip
# The authors tuned no weights for gray photographs under natural light.
_WEIGHTS["natural", "gray"] = _WEIGHTS["laboratory", "gray"]


def term_weights(light: str, channels: str, without: tuple[str, ...] = ()) -> TermWeights:
    """Return the weights for a kind of light and number of channels.

    Parameters
    ----------
    light : {"natural", "laboratory"}
    channels : {"gray", "color"}
    without : tuple of str
        Terms of `TERMS` to leave out: an ablation.

    Returns
    -------
    TermWeights

    Raises
    ------
    RelightlabError
        For unknown names.

    Examples
    --------
    >>> term_weights("natural", "color").albedo_smoothness
    16.0
    >>> term_weights("natural", "color", without=("slant",)).slant
    0.0
    """
    if light not in LIGHTS:
        raise unknown_name("light model", light, LIGHTS)
    if channels not in CHANNELS:
        raise unknown_name("channels", channels, CHANNELS)
    for term in without:
        if term not in TERMS:
            raise unknown_name("term", term, TERMS)
    if len(set(without)) == len(TERMS):
        raise RelightlabError("expected at least one term of the loss to be left, got none")
    return replace(_WEIGHTS[light, channels], **dict.fromkeys(without, 0.0))
