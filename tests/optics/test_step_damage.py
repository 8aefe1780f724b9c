"""A STEP file that lost something is refused, not traced as what is left of it."""

import numpy as np
import pytest

from mpfcad.backlight.lower import read_film
from mpfcad.cad import write_step
from mpfcad.errors import InputError
from mpfcad.film import Groove, PrismFilm


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    film = PrismFilm(Groove(0.05, 0.025), 0.2, 2.0, "filled", np.array([60.0, 50.0, 70.0]))
    path = tmp_path_factory.mktemp("film") / "film.step"
    write_step(film, path)
    read_film(path)
    return path.read_bytes()


@pytest.mark.parametrize(
    "word",
    ["EDGE_CURVE", "VERTEX_POINT", "PLANE", "ORIENTED_EDGE", "CARTESIAN_POINT", "ADVANCED_FACE",
     "CLOSED_SHELL"],
)  # fmt: skip
def test_an_entity_that_is_not_understood_is_no_smaller_film(tmp_path, whole, word):
    at = whole.rfind(word.encode() + b"(")
    path = tmp_path / "damaged.step"
    path.write_bytes(whole[:at] + b"X" + whole[at + 1 :])
    with pytest.raises(InputError, match=r"damaged\.step: ") as error:
        read_film(path)
    assert len(str(error.value).splitlines()) == 1
