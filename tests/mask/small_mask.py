"""Masks of a few grooves that the tests of this folder share."""

import numpy as np

from mpfcad.film import Groove, PrismFilm, read_process
from mpfcad.mask import MaskRules, build_mask, write_mask

BEF = Groove(0.050, 0.025)
PROCESS = read_process(None, BEF)
SLOT = MaskRules("slot", 0.400, 0.010, 0.015)
DOT = MaskRules("dot", 0.100, 0.010, 0.010)
CURVATURE = np.r_[np.linspace(55, 64, 30), [80.0] * 3, [60.0] * 4, 80.0, 58.0]
FORMATS = ("oas", "gds", "dxf", "gbr", "svg")


def build(curvature=CURVATURE, rules=SLOT, length=20.13, name="test-job"):
    film = PrismFilm(BEF, 0.2, length, "filled", np.asarray(curvature, float))
    return build_mask(film, PROCESS, rules, name)


def written(path, mask, tool=None):
    write_mask(mask, path, tool)
    return path


def flat_boxes(mask, first=0, last=None):
    """Return left, bottom, right, top of every aperture [nm], sorted, from the arrays' places."""
    found = []
    for array in mask.arrays:
        low = array.place.positions()
        found.append(np.hstack([low, low + np.array(array.shape)]))
    table = np.concatenate(found)
    return table[np.lexsort(table.T)]
