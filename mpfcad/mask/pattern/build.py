"""From a film to its mask: which kind of mask a film and a pattern make, and what is refused."""

import hashlib

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import HalftoneField, PanelFilm, Process, check_printable, groove_ranges
from mpfcad.mask.aperture import Mask
from mpfcad.mask.pattern.grooves import build_groove_mask
from mpfcad.mask.rule import GRID, MaskRules, dot_side, ratio_range, suggest_mesh

#: GDSII coordinates are 32-bit: no panel side may be longer [grid steps].
LARGEST_SIDE = 2_100_000_000
#: A level of a 2-D map of slots or dots holds over this share of the levelling length.
LEVEL_SHARE = 0.25


def build_mask(
    film: PanelFilm, process: Process, rules: MaskRules, name: str, where: str | None = None
) -> Mask:
    """Return the mask that prints a film.

    Parameters
    ----------
    film
        the panel
    process
        gives the aperture ratio of a curvature
    rules
        pattern, period and what the screen maker can make
    name
        the job's name, printable ASCII
    where
        what a refusal begins with, the job's file; None: `name`

    Raises
    ------
    InputError
        one line naming the grooves (counted from 0), the values and what is expected.
    """
    where = where or (name if name.isprintable() else repr(name))
    if film.profile != "filled":
        raise InputError(
            f"{where}: film.profile: {film.profile}: expected 'filled', resin only adds"
        )
    if not (name.isascii() and name.isprintable()):
        raise InputError(f"{where}: name: {name!r}: expected printable ASCII")
    low, high = film.extremes()
    is_halftone = film.varies_along and isinstance(film.as_field().field, HalftoneField)
    field = "halftone" if is_halftone else "map"
    check_printable(process, low, f"{where}: {field}")
    check_printable(process, high, f"{where}: {field}")
    for side, value in (("width", film.width), ("length", film.length)):
        if value / GRID > LARGEST_SIDE:
            raise InputError(
                f"{where}: stack.panel_{side}_mm: {value:g}: expected up to {LARGEST_SIDE * GRID:g}"
            )
    content_hash = _hash(film)
    if is_halftone:
        from mpfcad.mask.pattern.halftone import build_halftone_mask

        field_film = film.as_field()
        return build_halftone_mask(field_film, process, rules, name, content_hash, where)
    if not film.varies_along and not rules.is_stochastic:
        return build_groove_mask(film, process, rules, name, content_hash, where)
    if rules.pattern in ("staggered", "angled"):
        raise InputError(
            f"{where}: mask.pattern: {rules.pattern}: expected 'slot', 'dot', 'blue-noise' or "
            f"'error-diffused' for a map in both directions"
        )
    if rules.pattern == "error-diffused":
        return _build_dithered(film, process, rules, name, content_hash, where)
    return _build_tiled(film, process, rules, name, content_hash, where)


def _hash(film: PanelFilm) -> str:
    """Return the first 12 digits of SHA-256 over the curvatures, and a field's positions."""
    text = b"".join(value.astype("<f8").tobytes() for value in film.content)
    return hashlib.sha256(text).hexdigest()[:12]


def _check_ratio(
    where: str,
    film: PanelFilm,
    process: Process,
    rules: MaskRules,
    period: float,
    lowest: float,
) -> None:
    """Refuse grooves that take resin, with ratios outside `lowest` … what full cells give.

    Raises
    ------
    InputError
        one line naming the grooves, their ratios, and the ratios and curvatures expected.
    """
    pitch = film.groove.pitch
    highest = ratio_range(rules, pitch, period, where)[1]
    curvature = np.stack(film.extremes())
    ratio = process.aperture_ratio_of_curvature(curvature)
    # Dots of one size: a groove may thin out to nothing, if it has one dot anywhere.
    found = ratio.max(axis=0) if rules.pattern == "error-diffused" else ratio
    low = film.groove.takes_resin(curvature) & (found < lowest * (1 - 1e-6))
    bad = low | (ratio > highest * (1 + 1e-6))
    index = np.flatnonzero(bad.any(axis=0))
    if index.size:
        top, bottom = process.curvature(lowest), process.curvature(min(highest, 1.0))
        shown = ratio[bad]
        hint = suggest_mesh(rules, np.sqrt(shown * pitch * period), period)
        raise InputError(
            f"{where}: map: {groove_ranges(index)}: aperture_ratio {shown.min():.4g} … "
            f"{shown.max():.4g}: expected 0 or {lowest:.4g} … {highest:.4g} "
            f"({rules.describe(period)}), that is curvature_per_mm {bottom:.4g} … {top:.4g} or "
            f"{film.groove.curvature_empty:g} (no resin){hint}"
        )


def _build_dithered(
    film: PanelFilm,
    process: Process,
    rules: MaskRules,
    name: str,
    content_hash: str,
    where: str,
) -> Mask:
    from mpfcad.mask.pattern.dither import DitherMask, dither
    from mpfcad.mask.pattern.ratio import CellRatio

    cells = max(1, round(film.length / rules.period))
    pitch, period = film.groove.pitch, film.length / cells
    side = round(dot_side(rules, pitch, period, where) / GRID)
    one_dot = (side * GRID) ** 2 / (pitch * film.length)
    _check_ratio(where, film, process, rules, period, one_dot)
    steps = round(film.length / GRID) // cells
    spare = round(film.length / GRID) - steps * cells
    ratio = CellRatio.build(film, process, cells)
    edge = np.rint(film.tip_position / GRID).astype(np.int64)
    return DitherMask(
        name=name,
        content_hash=content_hash,
        rules=rules,
        pitch=pitch,
        length=film.length,
        groove_count=film.groove_count,
        ratio=ratio,
        is_dot=dither(ratio, (side * GRID) ** 2 / (pitch * period)),
        side=side,
        cell_steps=steps,
        left=edge[:-1] + (np.diff(edge) - side) // 2,
        bottom=spare // 2 + (steps - side) // 2,
    )


def _build_tiled(
    film: PanelFilm,
    process: Process,
    rules: MaskRules,
    name: str,
    content_hash: str,
    where: str,
) -> Mask:
    from mpfcad.mask.pattern.ratio import CellRatio
    from mpfcad.mask.pattern.tiles import LevelMask, quantise
    from mpfcad.mask.tile import TileShape, draw_tiles

    noise = rules.pattern == "blue-noise"
    share = rules.levelling_length * (1 if noise else LEVEL_SHARE)
    tile_cells = max(1, min(round(share / rules.period), round(film.length / rules.period)))
    tile_count = max(1, round(film.length / (tile_cells * rules.period)))
    cells = tile_cells * tile_count
    period, pitch = film.length / cells, film.groove.pitch
    if noise:
        lowest = rules.aperture_limit**2 / (pitch * period * tile_cells)
    else:
        lowest = ratio_range(rules, pitch, period, where)[0]
    _check_ratio(where, film, process, rules, period, lowest)
    edge = np.rint(film.tip_position / GRID).astype(np.int64)
    width = np.diff(edge)
    n = film.groove_count
    phase = np.arange(n) % tile_cells if noise else width - width.min()
    widths = (int(width.min()),) * tile_cells if noise else (int(width.min()), int(width.max()))
    ratio = CellRatio.build(film, process, cells)
    level: NDArray[np.integer]
    if film.varies_along:
        level, level_ratio = quantise(ratio, tile_cells)
    else:
        wanted = process.aperture_ratio_of_curvature(film.extremes()[0])
        level_ratio, of_groove = np.unique(np.append(0.0, wanted), return_inverse=True)
        level = np.asarray(of_groove[1:, None], np.int64)
    steps = round(film.length / GRID) // cells
    shape = TileShape(
        cells=tile_cells,
        cell_steps=steps,
        width=widths,
        pitch=pitch / GRID,
        period=period / GRID,
        dot=dot_side(rules, pitch, period, where) / GRID if noise else None,
        is_slot=rules.pattern == "slot",
    )
    key = np.unique(phase[:, None] * len(level_ratio) + level)
    keys = [divmod(int(k), len(level_ratio)) for k in key]
    tiles = draw_tiles(shape, [k for k in keys if k[1]], level_ratio)
    return LevelMask(
        name=name,
        content_hash=content_hash,
        rules=rules,
        pitch=pitch,
        length=film.length,
        groove_count=n,
        ratio=ratio,
        level=level,
        phase=phase,
        tiles=tiles,
        left=edge[:-1],
        bottom=(round(film.length / GRID) - steps * cells) // 2,
        tile_cells=tile_cells,
        tile_count=tile_count,
        cell_steps=steps,
    )
