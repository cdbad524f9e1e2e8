"""The whole group ``relightlab study``: importing a module below adds its commands to the app."""

from __future__ import annotations

from reports.commands import (
    study_analyze,
    study_data,
    study_design,
    study_load_test,
    study_power,
    study_serve,
)
from reports.commands.study import app

MODULES = (study_design, study_power, study_serve, study_load_test, study_data, study_analyze)
"""The modules whose commands the app has, in the order of ``--help``."""

__all__ = ["MODULES", "app"]
