"""The mask of a halftone: pieces with one aperture ratio, and pieces without any.

A printed piece holds a whole number of periods, so its apertures begin and end half a web within
it. A piece that the panel's edge cuts has none.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import FieldFilm, Halftone, HalftoneField, Process
from mpfcad.mask.pattern.ratio import PieceRatio
from mpfcad.mask.pattern.tiles import LevelMask
from mpfcad.mask.rule import GRID, MaskRules, ratio_range, suggest_mesh
from mpfcad.mask.tile import TileShape, draw_tiles
from mpfcad.units import um


@dataclass(frozen=True, eq=False)
class HalftoneMask(LevelMask):
    """A mask of equal pieces.

    Attributes
    ----------
    halftone
        the pieces of one cell
    """

    halftone: Halftone

    @property
    def printed_ratio(self) -> float:
        """Aperture ratio of a printed piece."""
        assert isinstance(self.ratio, PieceRatio)  # it is built so
        return self.ratio.ratio

    @cached_property
    def ratio_ends(self) -> tuple[float, float]:
        """Smallest wanted ratio above 0, and the largest: there is one."""
        return (self.printed_ratio,) * 2 if self.level.any() else (0.0, 0.0)

    @property
    def printed_share(self) -> NDArray[np.float64]:
        """Share of each groove's length that is to be printed, (n,) float64."""
        return self.wanted_ratio / self.printed_ratio

    @property
    def smallest_features(self) -> tuple[float | None, float | None]:
        """Smallest aperture and web as drawn [mm], None without any."""
        sizes = [array.size for tile in self.tiles.values() for array in tile.arrays]
        if not sizes:
            return None, None
        along, across = min(size[1] for size in sizes), min(size[0] for size in sizes)
        web = (self.cell_steps - max(size[1] for size in sizes)) * GRID
        if self.rules.pattern != "slot":
            beside = self.pitch - max(size[0] for size in sizes) * GRID
            return min(along, across) * GRID, min(web, beside)
        block = self.halftone.side_by_side * self.pitch
        return min(along * GRID, block), min(web, block)

    def wanted_places(self, cell: float) -> tuple[NDArray[np.float64], float]:
        """Return the ratio of the printed pieces: nothing else is printed."""
        return np.array(self.ratio_ends[:1]), cell

    def wanted_curvature(self, process: Process, cell: float) -> tuple[NDArray[np.float64], float]:
        """Return the map over a cell, (m, n) [1/mm]: that pieces end sharply is wanted."""
        return self.halftone.tone.T, self.pitch


def build_halftone_mask(
    film: FieldFilm,
    process: Process,
    rules: MaskRules,
    name: str,
    content_hash: str,
    where: str,
) -> HalftoneMask:
    """Return the mask of a film whose field is a halftone.

    Raises
    ------
    InputError
        when a screen has no such pattern, or holds no such aperture or web.
    """
    field = film.field
    assert isinstance(field, HalftoneField)  # `build_mask` has looked
    if rules.pattern not in ("slot", "dot"):
        raise InputError(
            f"{where}: mask.pattern: {rules.pattern}: expected 'slot' or 'dot' for a halftone"
        )
    cells = max(1, round(field.piece / rules.period))
    period, pitch = field.piece / cells, film.groove.pitch
    ratio = float(process.aperture_ratio_of_curvature(field.halftone.curvature))
    _check_rules(where, rules, ratio, period, field)
    start, printed = field.printed_pieces()
    edge = np.rint(film.tip_position / GRID).astype(np.int64)
    width = np.diff(edge)
    phase = width - width.min()
    steps = round(field.piece / GRID) // cells
    shape = TileShape(
        cells=cells,
        cell_steps=steps,
        width=tuple(range(int(width.min()), int(width.max()) + 1)),
        pitch=pitch / GRID,
        period=period / GRID,
        dot=None,
        is_slot=rules.pattern == "slot",
    )
    phases = np.unique(phase[printed.any(axis=1)])
    return HalftoneMask(
        name=name,
        content_hash=content_hash,
        rules=rules,
        pitch=pitch,
        length=film.length,
        groove_count=film.groove_count,
        ratio=PieceRatio(printed, ratio, field.piece, start, film.length),
        level=printed.astype(np.uint8),
        phase=phase,
        tiles=draw_tiles(shape, [(int(p), 1) for p in phases], np.array([0.0, ratio])),
        left=edge[:-1],
        bottom=round(start / GRID),
        tile_cells=cells,
        tile_count=printed.shape[1],
        cell_steps=steps,
        halftone=field.halftone,
    )


def _check_rules(
    where: str, rules: MaskRules, ratio: float, period: float, field: HalftoneField
) -> None:
    """Refuse apertures and webs that the screen does not hold; `period` [mm] is as made."""
    pitch, halftone = field.pitch, field.halftone
    low, high = ratio_range(rules, pitch, period, where)
    if not low * (1 - 1e-6) <= ratio <= high * (1 + 1e-6):
        size = period * ratio if rules.pattern == "slot" else (ratio * pitch * period) ** 0.5
        hint = suggest_mesh(rules, np.array([size]), period)
        raise InputError(
            f"{where}: halftone.curvature_per_mm: {halftone.curvature:g}: aperture_ratio "
            f"{ratio:.4g}: expected {low:.4g} … {high:.4g} ({rules.describe(period)}){hint}"
        )
    block, least = halftone.side_by_side * pitch, max(rules.aperture_limit, rules.web_limit)
    if rules.pattern == "slot" and block < least * (1 - 1e-9):
        raise InputError(
            f"{where}: halftone.grooves: {halftone.side_by_side}: slots {block / um:.4g} µm "
            f"wide across the grooves: expected {int(np.ceil(least / pitch - 1e-9))} or more, for "
            f"{least / um:.4g} µm ({rules.describe(period)})"
        )
