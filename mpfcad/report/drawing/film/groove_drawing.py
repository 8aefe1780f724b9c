"""A few grooves in cross-section: the surface is drawn from the corners in film.stl."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import MadeFilm
from mpfcad.report.drawing import svg
from mpfcad.units import um

#: Grooves in one group, and how much of the base below the valleys is shown [mm].
GROUP, BASE_SHOWN = 3, 0.008
SCALE = 2400.0
PRISM = 'fill="#c9dcee" stroke="#5d7f9f" stroke-width="0.8"'
RESIN = 'fill="#f2c572" stroke="none"'
SURFACE = 'stroke="#0b3d66" stroke-width="1.6"'


def draw_grooves(mesh: Path, made: MadeFilm, places: dict[str, int]) -> str:
    """Return the SVG of three grooves from each of `places` on (title -> groove of the film)."""
    film = made.film
    corner = read_section(mesh)
    most = max(film.groove_count - GROUP, 0)
    groups = [(f"{title}, groove {at} on", min(at, most)) for title, at in places.items()]
    width = GROUP * film.groove.pitch * SCALE
    height = (film.groove.depth + BASE_SHOWN) * SCALE
    parts = []
    for i, (title, first) in enumerate(groups):
        left = 20 + i * (width + 40)
        parts += _draw_group(corner, made, first, left, 34 + height)
        parts.append(svg.text(left, 18, title, 'font-size="13"'))
        parts += _legend(made, first, left, 52 + height)
    total = 20 + len(groups) * (width + 40)
    return svg.picture(total, height + 66, "Cross-section of the film, to scale", parts)


def read_section(mesh: Path) -> NDArray[np.float64]:
    """Return the (m, 2) corners x, z [mm] of the film's top at its near end, by x."""
    import trimesh

    vertices = np.asarray(trimesh.load(mesh, file_type="stl").vertices)
    near = vertices[(vertices[:, 1] == vertices[:, 1].min()) & (vertices[:, 2] > 0)]
    return np.unique(near[:, [0, 2]], axis=0)


def _draw_group(
    corner: NDArray[np.float64], made: MadeFilm, first: int, left: float, floor: float
) -> list[str]:
    """Return the drawing of the grooves from `first` on, its lower left corner at left, floor."""
    film = made.film
    pitch, tip = film.groove.pitch, film.tip_position
    last = min(first + GROUP, film.groove_count)
    low = film.base - BASE_SHOWN

    def place(x: float, z: float) -> tuple[float, float]:
        return left + (x - tip[first]) * SCALE, floor - (z - low) * SCALE

    margin = pitch * 1e-4
    inside = (corner[:, 0] > tip[first] - margin) & (corner[:, 0] < tip[last] + margin)
    shown = corner[inside]
    surface = [place(x, z) for x, z in shown]
    foot = [place(tip[last], low), place(tip[first], low)]
    x = np.union1d(shown[:, 0], film.groove_position[first:last])
    bare = made.bare_height(x)
    if bare is None:
        return [svg.polygon([*surface, *foot], PRISM), svg.polyline(surface, SURFACE)]
    prism_top = np.minimum(bare, np.interp(x, shown[:, 0], shown[:, 1]))
    walls = [place(*point) for point in zip(x, prism_top, strict=True)]
    resin = svg.polygon([*surface, *reversed(walls)], RESIN)
    prism = svg.polygon([*walls, *foot], PRISM)
    return [resin, prism, svg.polyline(surface, SURFACE)]


def _legend(made: MadeFilm, first: int, left: float, y: float) -> list[str]:
    film = made.film
    note = f"pitch {film.groove.pitch / um:g} µm, depth {film.groove.depth / um:g} µm"
    if made.imperfection.measured is None:
        note += f", C = {film.curvature[first]:.4g} /mm"
        if film.profile == "filled":
            note += f", fill {film.fill_fraction[first] * 100:.1f} %"
    return [svg.text(left, y, note, 'font-size="12" fill="#444"')]
