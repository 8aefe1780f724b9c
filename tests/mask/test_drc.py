"""What is too narrow is found, wherever it is; what is not is not marked."""

import dataclasses

import numpy as np
import pytest
from small_mask import BEF, FORMATS, PROCESS, build, written

from mpfcad.errors import ExportError
from mpfcad.film import PrismFilm
from mpfcad.mask import MaskRules, Phototool, build_mask, check_mask
from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.check.drc import find_narrow
from mpfcad.mask.fabric import find_mesh
from mpfcad.mask.format.drawing import draw
from mpfcad.mask.format.flat import columns_of, flat_tiles

RULES = {
    "slot": MaskRules("slot", 0.4, 0.01, 0.015),
    "slot through a mesh": MaskRules("slot", 1.5, 0.015, 0.015, mesh=find_mesh("180-27")),
    "dot": MaskRules("dot", 0.1, 0.01, 0.01),
    "staggered": MaskRules("staggered", 0.05, 0.008, 0.008),
    "angled": MaskRules("angled", 0.05, 0.008, 0.008),
    "blue-noise": MaskRules("blue-noise", 0.05, 0.008, 0.008),
    "error-diffused": MaskRules("error-diffused", 0.05, 0.008, 0.008),
}


class Planted:
    """A mask of which one aperture is not as it should be; the rest is the mask's."""

    def __init__(self, mask, arrays):
        self._mask, self.arrays, self.tile_arrays = mask, arrays, ()

    def __getattr__(self, name):
        return getattr(self._mask, name)


def plant(mask, generator):
    """Return the mask with one aperture too small, or too near to the next, at a random place."""
    drawing = draw(mask, Phototool(), paints=True)
    columns = list(columns_of([*drawing.arrays, *flat_tiles(drawing)]))
    number = int(generator.integers(len(columns)))
    column = columns.pop(number)
    place, (width, length) = column.place, column.shape
    row = int(generator.integers(place.rows))
    x, y = place.origin
    step = place.row_step[1]
    for first, count in ((0, row), (row + 1, place.rows - row - 1)):
        if count:
            rest = Placement((x, y + first * step), rows=count, row_step=(0, step))
            columns.append(ApertureArray(column.shape, rest))
    at, shape = (x, y + row * step), (width, length)
    limit = round(mask.rules.aperture_limit * 1e6)
    if generator.random() < 0.5:
        shape = (width, int(generator.integers(limit // 4, limit - 3)))
    else:
        web = round(mask.rules.web_limit * 1e6)
        at = (x, at[1] + int(generator.choice([-1, 1])) * int(generator.integers(4, web)))
    columns.append(ApertureArray(shape, Placement(at)))
    return Planted(mask, columns)


def is_found(path, mask):
    try:
        check = check_mask(path, mask)
    except ExportError:
        return True
    sizes = (check.smallest_aperture, check.smallest_web)
    limits = (mask.rules.aperture_limit, mask.rules.web_limit)
    narrow = any(size < limit - 2e-6 for size, limit in zip(sizes, limits, strict=True))
    return narrow or bool(check.windows.violations)


def random_curvature(generator, count):
    x = np.arange(count)
    return 58 + 3.5 * np.sin(generator.uniform(0.005, 0.2) * x + generator.uniform(0, 6))


def hunt(tmp_path, planted, clean, seed):
    """Plant so many violations, one a file, and read so many clean masks; return both tallies."""
    generator = np.random.default_rng(seed)
    names, found, invented = list(RULES), 0, []
    for i in range(max(planted, clean)):
        rules = RULES[names[i % len(names)]]
        mask = build(random_curvature(generator, 40), rules, length=generator.uniform(8, 24))
        suffix = FORMATS[i % len(FORMATS)]
        if i < planted:
            found += is_found(written(tmp_path / f"p.{suffix}", plant(mask, generator)), mask)
        if i < clean:
            check = check_mask(written(tmp_path / f"c.{suffix}", mask), mask)
            if check.windows.violations or is_found(tmp_path / f"c.{suffix}", mask):
                invented.append((names[i % len(names)], suffix))
    return found, invented


def test_planted_violations_are_found_and_none_is_invented(tmp_path):
    assert hunt(tmp_path, planted=35, clean=14, seed=1) == (35, [])


@pytest.mark.slow
def test_a_thousand_planted_violations(tmp_path):
    assert hunt(tmp_path, planted=1000, clean=100, seed=2) == (1000, [])


def test_one_aperture_among_millions_is_named(tmp_path):
    """The panel: 7846 grooves, 8.5 million slots; one is moved by 1 nm."""
    from test_mask_file import panel

    mask = panel()
    arrays = list(mask.arrays)
    array = arrays[5000]
    place = array.place
    first = Placement(place.origin, rows=place.rows - 1, row_step=place.row_step)
    end = place.origin[1] + (place.rows - 1) * place.row_step[1] + 1
    arrays[5000:5001] = [
        ApertureArray(array.shape, first),
        ApertureArray(array.shape, Placement((place.origin[0], end))),
    ]
    path = written(tmp_path / "m.oas", Planted(mask, arrays))
    with pytest.raises(ExportError, match=r"groove 5000 \(counted from 0\): an aperture is not"):
        check_mask(path, mask)


def region(*boxes):
    import klayout.db as kdb

    found = kdb.Region()
    for box in boxes:
        found.insert(kdb.Box(*box))
    return found.merged()


BOX = (0, 0, 1_000_000, 1_000_000)


def test_steps_between_neighbouring_grooves_are_no_marker():
    """A slot of 60 µm, drawn groove by groove of 50 µm, steps by up to 0.9 µm; limit 55.6 µm."""
    generator = np.random.default_rng(3)
    for _ in range(20):
        edge = np.cumsum(generator.integers(-900, 900, 40)) + 400_000
        slots = [
            (i * 50_000, e, (i + 1) * 50_000, e + 60_000 + int(generator.integers(0, 900)))
            for i, e in enumerate(edge.tolist())
        ]
        assert find_narrow(region(*slots), BOX, 55_552, 55_552) == []


def test_a_window_s_cut_is_no_marker():
    feet = range(-990_000, 2_000_000, 400_000)
    slots = region(*((-200_000, y, 1_200_000, y + 60_000) for y in feet))
    assert find_narrow(slots, BOX, 55_552, 55_552) == []


@pytest.mark.parametrize(
    ("rule", "boxes"),
    [
        ("min_aperture", [(100_000, 100_000, 300_000, 140_000)]),
        ("min_aperture", [(100_000, 100_000, 130_000, 400_000)]),
        ("min_aperture", [(100_000, 100_000, 300_000, 101_000)]),
        ("min_aperture", [(100_000, 100_000, 300_000, 200_000),
                          (300_000, 130_000, 500_000, 150_000)]),
        ("min_web", [(100_000, 100_000, 300_000, 200_000), (100_000, 240_000, 300_000, 400_000)]),
        ("min_web", [(100_000, 100_000, 300_000, 200_000), (310_000, 210_000, 500_000, 400_000)]),
        ("min_web", [(100_000, 100_000, 500_000, 200_000), (100_000, 200_000, 250_000, 400_000),
                     (280_000, 200_000, 500_000, 400_000)]),
    ],
)  # fmt: skip
def test_what_is_too_narrow_is_marked(rule, boxes):
    found = find_narrow(region(*boxes), BOX, 55_552, 55_552)
    assert {violation.rule for violation in found} == {rule}


def test_masks_that_a_finer_screen_could_hold_fail_a_coarser_one(tmp_path):
    mask = build([60.0] * 30, RULES["slot"])
    coarse = dataclasses.replace(mask, rules=dataclasses.replace(mask.rules, min_aperture=0.05))
    bare = Phototool(furniture=())
    check = check_mask(written(tmp_path / "m.oas", mask, bare), coarse, bare)
    assert check.smallest_aperture < 0.05
    assert {violation.rule for violation in check.windows.violations} == {"min_aperture"}


def test_the_map_that_ships_has_no_false_marker(tmp_path):
    """Steps of 0.03 to 0.9 µm between grooves, through the mesh it is printed with."""
    rows = np.loadtxt("masks/patterned-16mm.csv", delimiter=",", skiprows=1)
    centres = (np.arange(660) + 0.5) * 0.05
    curvature = np.interp(centres % 32.69, rows[:, 0], rows[:, 1])
    rules = MaskRules("slot", 2.269, 0.015, 0.015, mesh=find_mesh("180-27"))
    mask = build_mask(PrismFilm(BEF, 0.2, 60.0, "filled", curvature), PROCESS, rules, "job")
    check = check_mask(written(tmp_path / "m.gds", mask), mask)
    assert check.windows.violations == ()
