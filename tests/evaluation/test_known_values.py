"""Tests of numbers of which some are not known."""

from __future__ import annotations

import json
import math

import numpy as np

from evaluation.known_values import mean_of_known, rows_without_nan


def test_the_mean_is_over_what_is_known() -> None:
    """Neither NaN nor infinity takes part, and of nothing the mean is NaN."""
    assert mean_of_known(np.array([[1.0, np.nan], [np.inf, 4.0]])) == 2.5
    assert math.isnan(mean_of_known(np.array([np.nan])))
    assert math.isnan(mean_of_known(np.array([])))


def test_rows_can_be_written_as_json() -> None:
    """NaN alone becomes None; words, whole numbers and lists stay as they are."""
    row = {"imse": math.nan, "object": "sun", "cells": 3, "order": ["contour"]}
    (found,) = rows_without_nan([row])
    assert found == {"imse": None, "object": "sun", "cells": 3, "order": ["contour"]}
    assert json.loads(json.dumps(found, allow_nan=False)) == found
