"""Masks of a few kilobytes that state 10⁹ places are refused at once."""

import zlib

import klayout.db as kdb
import pytest
from small_mask import build, written

from mpfcad.errors import ExportError
from mpfcad.mask import check_mask
from mpfcad.mask.layer import APERTURE, FIDUCIAL


def crowded(path, layer, *, nested):
    """Add an array of 32000 by 32000 references to a mask's file."""
    layout = kdb.Layout(False)
    layout.read(str(path))
    top, cell = layout.top_cell(), layout.create_cell("ONE")
    cell.shapes(layout.layer(layer, 0)).insert(kdb.Box(0, 0, 1000, 1000))
    if nested:
        tile = layout.create_cell("TILE")
        step = kdb.Vector(2000, 0), kdb.Vector(0, 2000)
        tile.insert(kdb.CellInstArray(cell.cell_index(), kdb.Trans(), *step, 2, 2))
        cell = tile
    step = kdb.Vector(10, 0), kdb.Vector(0, 10)
    place = kdb.Trans(kdb.Vector(100, 100))
    top.insert(kdb.CellInstArray(cell.cell_index(), place, *step, 32000, 32000))
    layout.write(str(path))


@pytest.mark.parametrize("suffix", ["gds", "oas"])
@pytest.mark.parametrize("layer", [APERTURE, FIDUCIAL])
def test_a_file_that_states_a_thousand_million_places_is_refused(tmp_path, suffix, layer):
    mask = build()
    path = written(tmp_path / f"mask.{suffix}", mask)
    crowded(path, layer, nested=layer == APERTURE)
    if suffix == "oas":
        data = path.read_bytes()[:-4]
        path.write_bytes(data + zlib.crc32(data).to_bytes(4, "little"))
    with pytest.raises(ExportError, match=r"places: expected at most|fiducials: expected 4"):
        check_mask(path, mask)
