"""The project's own files, as its tests of itself read them."""

from __future__ import annotations

import ast
import subprocess
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("shading_model", "datasets", "evaluation", "studies", "reports")
_MADE = {"build", "dist", "out"}


@cache
def committed_files() -> tuple[Path, ...]:
    """Return the committed files; outside a git checkout, all that set-up did not make."""
    try:
        listing = subprocess.run(
            ["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True
        ).stdout.split("\0")
    except (OSError, subprocess.CalledProcessError):
        listing = [str(path.relative_to(ROOT)) for path in ROOT.rglob("*") if _is_source(path)]
    return tuple(sorted(ROOT / name for name in listing if name and (ROOT / name).is_file()))


def _is_source(path: Path) -> bool:
    first, *rest = path.relative_to(ROOT).parts
    parts = [first, *rest]
    hidden = first.startswith(".") and first not in {".ci", ".gitignore"}
    return not (hidden or first in _MADE or "__pycache__" in parts or ".egg-info" in first)


@cache
def parsed(*folders: str) -> tuple[tuple[Path, ast.Module], ...]:
    """Return the committed modules of the given top folders, with their syntax trees."""
    return tuple(
        (path.relative_to(ROOT), ast.parse(path.read_text(encoding="utf-8")))
        for path in committed_files()
        if path.suffix == ".py" and path.relative_to(ROOT).parts[0] in folders
    )


def imports_of(tree: ast.Module) -> set[str]:
    """Return the full dotted names of the modules a syntax tree imports, wherever it does so."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names.add(node.module)
    return names
