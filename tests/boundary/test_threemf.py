"""Items of 3MF files that say something wrong end in one line."""

import zipfile

import numpy as np
import pytest

from mpfcad.boundary.threemf import read_instances
from mpfcad.errors import InputError

PLACE = "1 0 0 0 1 0 0 0 1 0 0"
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"


def write(folder, *items: tuple[str, str]):
    path = folder / "film.3mf"
    body = "".join(f'<item objectid="{one}" transform="{place}"/>' for one, place in items)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("_rels/.rels", "<Relationships/>")
        archive.writestr("3D/3dmodel.model", f'<model xmlns="{CORE}"><build>{body}</build></model>')
    return path


def test_numbers_and_places_are_those_of_the_items(tmp_path):
    found = read_instances(write(tmp_path, ("7", f"{PLACE} 0"), ("2147483647", f"{PLACE}\n 0.5")))
    assert found.number.tolist() == [7, 2**31 - 1]
    assert np.array_equal(found.transform[:, 3], [[0, 0, 0], [0, 0, 0.5]])


@pytest.mark.parametrize("number", ["99999999999999999999", "2147483648", "-1", "0", "1_0", "1.5"])
def test_what_is_no_number_of_an_object_is_refused(tmp_path, number):
    with pytest.raises(InputError, match=f"3MF: objectid '{number}': not from 1 to 2147483647"):
        read_instances(write(tmp_path, (number, f"{PLACE} 0")))


@pytest.mark.parametrize(
    ("places", "match"),
    [
        ((PLACE, f"{PLACE} 0 5"), "a transform of 11 numbers, not 12"),  # 24 in all
        ((f"{PLACE} nan",), "a transform with a number that is not finite"),
        ((f"{PLACE} 1e999",), "a transform with a number that is not finite"),
    ],
)
def test_each_transform_has_its_own_twelve_numbers(tmp_path, places, match):
    with pytest.raises(InputError, match=match):
        read_instances(write(tmp_path, *(("1", place) for place in places)))
