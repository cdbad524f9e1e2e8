"""Table 2 as published (`tab:shaperes`), on ten objects that were never released."""

from __future__ import annotations

from typing import Any

PUBLISHED: tuple[dict[str, Any], ...] = tuple(
    {"shape": shape, "weights": weights, "imse": imse}
    for weights, values in (
        ("default", (0.0723, 0.0732, 0.0690, 0.0537)),
        ("oracle", (0.0295, 0.0304, 0.0334, 0.0194)),
    )
    for shape, imse in zip(("contour", "kinect", "sirfs", "sirfs-stereo"), values, strict=True)
)
"""One row for each published entry."""
