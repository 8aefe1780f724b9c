"""The cross-section of one groove with its dimensions, as a drawing for the mould shop."""

import numpy as np

from mpfcad.film import MadeFilm
from mpfcad.report.drawing import svg
from mpfcad.report.drawing.film.groove_drawing import PRISM, RESIN, SURFACE
from mpfcad.units import deg, um

#: Pixels a millimetre, and how much of the base is shown below the valley [mm].
SCALE, BASE_SHOWN = 9000.0, 0.010
LEFT, TOP = 190.0, 76.0
THIN = 'stroke="#555" stroke-width="0.8"'
LABEL = 'font-size="13" fill="#222"'
CENTRED = LABEL + ' text-anchor="middle"'


def draw_dimensions(made: MadeFilm, index: int) -> str:
    """Return the SVG of groove `index` with pitch, depth, vertex, contact, base and radii."""
    film, imperfection = made.film, made.imperfection
    groove, measured = film.groove, imperfection.measured is not None
    curvature = float(film.curvature[index])
    contact = float(groove.contact_position(curvature))
    vertex = float(groove.vertex_height(curvature))
    filled = film.profile == "filled" and not measured
    sharp = not (imperfection.tip_radius or imperfection.valley_radius)
    w, depth = groove.half_width, groove.depth
    width, height = groove.pitch * SCALE, (depth + BASE_SHOWN) * SCALE

    def place(x: float, z: float) -> tuple[float, float]:
        """Return where x from the groove's centre and z above the valley are drawn."""
        return LEFT + (x + w) * SCALE, TOP + (depth - z) * SCALE

    x = np.linspace(-w, w, 201)
    centre = float(film.groove_position[index])
    profile = made.section().height(centre + x) - film.base
    bare = made.bare_height(centre + x)
    surface = [place(*point) for point in zip(x, profile, strict=True)]
    foot = [place(w, -BASE_SHOWN), place(-w, -BASE_SHOWN)]
    walls = surface
    if bare is not None:
        lower = np.minimum(bare - film.base, profile)
        walls = [place(*point) for point in zip(x, lower, strict=True)]
    body = [svg.polygon([*(walls if filled else surface), *foot], PRISM)]
    if filled:
        body.append(svg.polygon([*surface, *reversed(walls)], RESIN))
    body.append(svg.polyline(surface, SURFACE))

    right, bottom = LEFT + width, TOP + height
    parts = [*body, *_across(LEFT, right, TOP - 42, TOP, f"pitch {groove.pitch / um:g} µm")]
    parts += _up(right + 40, place(w, depth)[1], place(w, 0)[1], f"depth {depth / um:g} µm")
    parts.append(svg.line(*place(0, 0), right + 48, place(0, 0)[1], THIN))
    parts.append(svg.line(right, TOP, right + 48, TOP, THIN))
    parts += _up(right + 40, place(0, 0)[1], bottom, f"base {film.base / um:g} µm (cut off)")
    if filled and sharp and 0 < contact < w:
        words = f"2 x contact = {2 * contact / um:.4g} µm"
        ends = [place(sign * contact, groove.wall_slope * contact) for sign in (-1, 1)]
        parts += _across(ends[0][0], ends[1][0], TOP - 14, ends[0][1], words)
    if not measured and (not filled or vertex > 0):
        low, high = place(0, 0)[1], place(0, vertex)[1]
        dashed = THIN + ' stroke-dasharray="4"'
        parts += [svg.line(LEFT - 48, y, place(0, 0)[0], y, dashed) for y in (high, low)]
        parts += _up(LEFT - 40, high, low, f"z0 {vertex / um:.4g} µm", before=True)
    note = f"groove {index} of the piece: z = z0 + C/2 x², C = {curvature:.6g} /mm"
    if measured:
        note = f"groove {index} of the piece: measured profile"
    parts.append(svg.text(LEFT, bottom + 24, note, LABEL))
    angle = 2 * np.arctan2(w, depth) / deg
    note = f"prism angle {angle:.5g}°"
    for name, radius in (("tip", imperfection.tip_radius), ("valley", imperfection.valley_radius)):
        note += f", {name} radius {radius / um:g} µm" if radius else ""
    parts.append(svg.text(LEFT, bottom + 42, note, LABEL))
    return svg.picture(right + 200, bottom + 58, "Cross-section with dimensions", parts)


def _across(left: float, right: float, y: float, reach: float, words: str) -> list[str]:
    """Return a dimension from left to right at y, with lines down to `reach`."""
    ends = [svg.line(x, y - 6, x, reach, THIN) for x in (left, right)]
    heads = [*_head(left, y, 7, 0), *_head(right, y, -7, 0)]
    middle = (left + right) / 2
    label = svg.text(middle, y - 6, words, CENTRED)
    return [*ends, svg.line(left, y, right, y, THIN), *heads, label]


def _up(x: float, top: float, bottom: float, words: str, before: bool = False) -> list[str]:
    """Return a dimension from top to bottom at x, its words after or before it."""
    heads = [*_head(x, top, 0, 7), *_head(x, bottom, 0, -7)]
    anchor = LABEL + (' text-anchor="end"' if before else "")
    label = svg.text(x - 10 if before else x + 10, (top + bottom) / 2 + 4, words, anchor)
    return [svg.line(x, top, x, bottom, THIN), *heads, label]


def _head(x: float, y: float, along: float, down: float) -> list[str]:
    """Return an arrow head at x, y whose tail lies `along`, `down` from there."""
    side = (down / 2.5, along / 2.5)
    tail = [(x + along + sign * side[0], y + down + sign * side[1]) for sign in (-1, 1)]
    return [svg.polygon([(x, y), *tail], 'fill="#555" stroke="none"')]
