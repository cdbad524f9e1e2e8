"""Fixtures that several modules of these tests share, each made once."""

from __future__ import annotations

from tests.reports.small_result import small_result
from tests.reports.small_study import small_study

__all__ = ["small_result", "small_study"]
