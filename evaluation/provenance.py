"""Where a result came from: code, data, seeds, versions and machine."""

from __future__ import annotations

import os
import platform
import subprocess
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

VERSIONED = (
    *("numpy", "scipy", "pyamg", "opencv-python-headless", "numba"),
    *("pillow", "joblib", "mitsuba", "matplotlib"),
)
UNKNOWN = "unknown"


@dataclass(frozen=True)
class Provenance:
    """What a reader needs to repeat a result.

    Parameters
    ----------
    project : str
        Version of relightlab.
    commit : str
        Git commit of the code, with ``+changes`` if files differed from it; ``unknown`` for an
        installed package.
    protocol : str
        Name and version of the protocol.
    dataset : str
    data_hash : str
        Fingerprint of the dataset's content.
    seeds : dict of str
        Names that random draws were seeded from.
    python, machine : str
    versions : dict of str
        Packages that numbers depend on.
    seconds : float
        Run time.
    workers : int
    cells_done, cells_missing : int
    """

    project: str
    commit: str
    protocol: str
    dataset: str
    data_hash: str
    seeds: dict[str, str]
    python: str
    machine: str
    versions: dict[str, str]
    seconds: float
    workers: int
    cells_done: int
    cells_missing: int

    def document(self) -> dict[str, Any]:
        """Return the record as plain JSON values."""
        return asdict(self)


def provenance_of(
    *,
    protocol: str,
    dataset: str,
    data_hash: str,
    seeds: dict[str, str],
    seconds: float,
    workers: int,
    cells_done: int,
    cells_missing: int,
) -> Provenance:
    """Return the provenance of a run that ends now, on this machine, by this code.

    Parameters
    ----------
    protocol, dataset, data_hash : str
    seeds : dict of str
    seconds : float
    workers, cells_done, cells_missing : int
        See `Provenance`.

    Returns
    -------
    Provenance
    """
    return Provenance(
        project=version("relightlab"),
        commit=code_commit(),
        protocol=protocol,
        dataset=dataset,
        data_hash=data_hash,
        seeds=seeds,
        python=platform.python_version(),
        machine=machine(),
        versions={name: version(name) for name in VERSIONED},
        seconds=round(seconds, 1),
        workers=workers,
        cells_done=cells_done,
        cells_missing=cells_missing,
    )


def machine() -> str:
    """Return the kind of machine, without its name.

    Examples
    --------
    >>> "processors" in machine()
    True
    """
    return f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors"


def environment() -> str:
    """Return Python, the packages that numbers depend on, and the machine, in one line.

    Examples
    --------
    >>> environment().startswith("Python ")
    True
    """
    packages = ", ".join(f"{name} {version(name)}" for name in VERSIONED)
    return f"Python {platform.python_version()}, {packages}; {machine()}"


def code_commit() -> str:
    """Return the git commit of the checkout this code runs from; see `Provenance.commit`.

    Examples
    --------
    >>> len(code_commit()) >= len(UNKNOWN)
    True
    """
    module = Path(__file__).resolve()
    folder = module.parent
    try:
        # An installed copy may lie in an environment inside somebody else's checkout.
        _git(folder, "ls-files", "--error-unmatch", module.name)
        commit = _git(folder, "rev-parse", "HEAD")
        changed = _git(folder, "status", "--porcelain", "--untracked-files=no")
    except (OSError, subprocess.CalledProcessError):
        return UNKNOWN
    return f"{commit}+changes" if changed else commit


def _git(folder: Path, *words: str) -> str:
    command = ["git", "-C", str(folder), *words]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return done.stdout.strip()
