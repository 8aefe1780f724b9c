"""Films for the CAD tests: a few grooves of the 25 × 50 µm BEF on a 0.2 mm base."""

from collections.abc import Callable

import numpy as np
import pytest

from mpfcad.film import Groove, PrismFilm, Profile

BEF = Groove(0.050, 0.025)


@pytest.fixture
def make_film() -> Callable[..., PrismFilm]:
    def make(
        curvature: object, profile: Profile = "filled", count: int = 3, length: float = 2.0
    ) -> PrismFilm:
        values = np.atleast_1d(np.asarray(curvature, float))
        if values.size == 1:
            values = np.full(count, values[0])
        return PrismFilm(BEF, 0.2, length, profile, values)

    return make
