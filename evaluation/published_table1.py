"""The Table 1 that was published, and the entries of it that a quick run leaves out."""

from __future__ import annotations

PUBLISHED: tuple[dict[str, str | float], ...] = tuple(
    {"setting": setting, "method": method, "detail_source": source, "weights": rule, "imse": imse}
    for setting, method, source, rule, imse in (
        ("natural", "sirfs", "default", "none", 0.0172),
        ("laboratory", "sirfs", "default", "none", 0.0372),
        ("natural", "ours", "default", "regression", 0.0358),
        ("natural", "ours", "default", "oracle", 0.0329),
        ("natural", "ours", "sirfs-shading", "regression", 0.0320),
        ("natural", "ours", "sirfs-shading", "oracle", 0.0274),
        ("natural", "ours", "gt-shading", "regression", 0.0243),
        ("natural", "ours", "gt-shading", "oracle", 0.0206),
        ("laboratory", "ours", "default", "regression", 0.0641),
        ("laboratory", "ours", "default", "oracle", 0.0586),
        ("laboratory", "ours", "sirfs-shading", "regression", 0.0360),
        ("laboratory", "ours", "sirfs-shading", "oracle", 0.0341),
        ("laboratory", "ours", "gt-shading", "regression", 0.0240),
        ("laboratory", "ours", "gt-shading", "oracle", 0.0228),
    )
)
"""The published Table 1 (`tab:mse`). Its lights, and so its scale, are not known."""

OPEN_ENTRIES: tuple[dict[str, str], ...] = tuple(
    {"setting": setting, "method": method, "detail_source": source}
    for setting in ("natural", "laboratory")
    for method, source in (("sirfs", "default"), ("ours", "sirfs-shading"))
)
"""Entries that need SIRFS, which a quick run does without."""
