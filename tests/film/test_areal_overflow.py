"""Areal maps whose slopes overflow are refused, and no direction is made of NaN."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film.stylus.file.areal import ArealMap, cut_profile


@pytest.mark.parametrize(("factor", "step"), [(1e200, 1e-3), (1.0, 1e-200)])
def test_slopes_beyond_floats_are_one_line(factor, step):
    height = np.repeat(np.abs(np.arange(40.0) % 20 - 10)[None] * factor, 8, axis=0)
    area = ArealMap(height, step, step, "mm", "mm")
    with warnings.catch_warnings(), pytest.raises(InputError, match=r"a: heights up to \S+ at ste"):
        warnings.simplefilter("error")
        cut_profile(Path("a"), area)
