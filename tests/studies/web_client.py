"""FastAPI's test client, imported past a warning about what it is built on."""

from __future__ import annotations

import warnings

with warnings.catch_warnings():
    # It would rather have a successor of httpx, which it can do without.
    warnings.simplefilter("ignore")
    from fastapi.testclient import TestClient

__all__ = ["TestClient"]
