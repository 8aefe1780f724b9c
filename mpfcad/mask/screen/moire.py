"""Moiré: the slow beats of two fine gratings, which of them show, and what avoids them.

Gratings multiply, so harmonics f and g beat at f - g and f + g (vectors, 1/mm), with the contrast
2·A·B for amplitudes A and B over the mean. Four gratings meet: the mask's pattern, the screen's
mesh, the prisms, the display's pixels. What stands in the resin (pattern, mesh, and what they make
with the prisms' grooves) fades as the resin levels along the grooves, by exp(-2 π² σ² f_along²).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.pattern.levelling import FULL_WIDTH
from mpfcad.mask.rule import MaskRules
from mpfcad.units import deg

#: Highest order of a grating's harmonics.
ORDERS = 3
#: Beats longer than this are shading, not stripes [mm].
LONGEST = 50.0
#: Fine detail that an eye resolves: the angle of one period, two minutes of arc.
EYE = 2 / 60 * deg
#: Contrast above which stripes show.
VISIBLE_CONTRAST = 0.005
#: Open share of a pixel in either direction: assumed.
PIXEL_OPEN = 0.8
#: Colours side by side in a pixel, along the grooves (the screen's long side).
COLOURS = 3


@dataclass(frozen=True, eq=False)
class Grating:
    """The harmonics of something periodic.

    Attributes
    ----------
    name
        what it is
    order
        (m, 2) int
    frequency
        (m, 2) float64, across and along [1/mm]
    amplitude
        (m,) float64, over the mean
    in_resin
        whether it is printed, so that it levels
    """

    name: str
    order: NDArray[np.int64]
    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    in_resin: bool


@dataclass(frozen=True)
class Beat:
    """One beat: who with whom, by which orders; period [mm], direction [rad], contrast."""

    pair: tuple[str, str]
    order: tuple[tuple[int, int], tuple[int, int]]
    period: float
    direction: float
    contrast: float
    is_visible: bool


@dataclass(frozen=True)
class MoireSetting:
    """What a mask is looked at with and through.

    Attributes
    ----------
    mesh_angle
        of the threads to the grooves [rad]
    pixel
        pitch of the display's pixels [mm]; None: no display
    viewing_distance
        [mm]
    """

    mesh_angle: float = 22.5 * deg
    pixel: float | None = None
    viewing_distance: float = 500.0

    @property
    def shortest(self) -> float:
        """Shortest period that an eye resolves [mm]."""
        return self.viewing_distance * EYE


def _harmonics(
    name: str,
    basis: NDArray[np.float64],
    size: tuple[float, float],
    in_resin: bool,
    turn: float = 0.0,
) -> Grating:
    """Return the grating of rectangles of `size` [mm] on a lattice; `basis` (2, 2) [1/mm].

    The amplitude of frequency f is sinc(f_across · width) · sinc(f_along · length); a basis row of
    zeros is a direction without order. `turn` [rad] turns the whole.
    """
    k = np.arange(-ORDERS, ORDERS + 1)
    order = np.stack(np.meshgrid(k, k, indexing="ij"), axis=-1).reshape(-1, 2)
    order = order[(order[:, 0] > 0) | ((order[:, 0] == 0) & (order[:, 1] > 0))]
    order = order[~((order != 0) & (np.abs(basis).sum(axis=1) == 0)).any(axis=1)]
    frequency = order @ basis
    amplitude = np.abs(np.sinc(frequency[:, 0] * size[0]) * np.sinc(frequency[:, 1] * size[1]))
    c, s = np.cos(turn), np.sin(turn)
    return Grating(name, order, frequency @ np.array([[c, s], [-s, c]]), amplitude, in_resin)


def pattern_grating(rules: MaskRules, pitch: float, ratio: float) -> Grating:
    """Return the grating of a mask's pattern at an aperture ratio; `pitch` [mm]."""
    period = rules.period
    basis = np.array([[1 / pitch, 0.0], [0.0, 1 / period]])
    side = (ratio * pitch * period) ** 0.5
    size = (pitch, ratio * period) if rules.pattern == "slot" else (side, side)
    if rules.pattern == "staggered":
        basis[1, 0] = -0.5 / pitch  # half a period a groove
    elif rules.pattern == "angled":
        basis[1, 0] = -np.tan(rules.angle) / period
    elif rules.is_stochastic:
        dot = min(pitch, period) - rules.web_limit if rules.dot is None else rules.dot
        basis[1], size = 0.0, (dot, dot)
    return _harmonics("pattern", basis, size, True)


def gratings(rules: MaskRules, setting: MoireSetting, pitch: float, ratio: float) -> list[Grating]:
    """Return the gratings that meet: pattern, mesh, prisms, pixels, as far as they are known."""
    found = [pattern_grating(rules, pitch, ratio)]
    if rules.mesh is not None:
        mesh, basis = rules.mesh, np.eye(2) * rules.mesh.count
        hole = mesh.open_area**0.5 * mesh.cell
        found.append(_harmonics("mesh", basis, (hole, hole), True, setting.mesh_angle))
    # The luminance of a prism over its width is not known here: amplitudes of a half-lit one.
    prism = np.array([[1 / pitch, 0.0], [0.0, 0.0]])
    found.append(_harmonics("prism", prism, (pitch / 2, 0.0), False))
    if setting.pixel is not None:
        p = setting.pixel
        basis = np.array([[1 / p, 0.0], [0.0, COLOURS / p]])
        size = (PIXEL_OPEN * p, PIXEL_OPEN * p / COLOURS)
        found.append(_harmonics("pixel", basis, size, False))
    return found


def find_beats(
    found: Sequence[Grating], setting: MoireSetting, levelling_length: float
) -> list[Beat]:
    """Return the beats of all pairs with a period up to `LONGEST` that an eye resolves.

    Strongest first; beats of a thousandth of `VISIBLE_CONTRAST` are left out, and so are exact
    coincidences, whose period has no end.
    """
    beats = []
    for a, b in combinations(found, 2):
        for sign in (1, -1):
            frequency = a.frequency[:, None] - sign * b.frequency
            contrast = 2 * a.amplitude[:, None] * b.amplitude
            contrast = contrast * _levelled(a, b, frequency, levelling_length)
            size = np.hypot(frequency[..., 0], frequency[..., 1])
            kept = (size >= 1 / LONGEST) & (size <= 1 / setting.shortest)
            kept &= contrast > VISIBLE_CONTRAST / 1000
            for i, j in np.argwhere(kept):
                f, c = frequency[i, j], float(contrast[i, j])
                (p, q), (r, s) = map(int, a.order[i]), map(int, sign * b.order[j])
                order = ((p, q), (r, s))
                angle = float(np.arctan2(f[1], f[0]) % np.pi)
                pair = (a.name, b.name)
                period = float(1 / size[i, j])
                beats.append(Beat(pair, order, period, angle, c, c >= VISIBLE_CONTRAST))
    return sorted(beats, key=lambda beat: (-beat.contrast, beat.pair, beat.order))


def _levelled(
    a: Grating, b: Grating, frequency: NDArray[np.float64], levelling_length: float
) -> NDArray[np.float64]:
    """Return what levelling leaves of each beat (m, k): of what stands in the resin only.

    Pattern, mesh and prisms make their beats in the resin; a pixel beats with levelled resin.
    """
    along = frequency[..., 1]
    if "pixel" in (a.name, b.name):
        resin, axis = (b, 0) if a.name == "pixel" else (a, 1)
        along = np.expand_dims(resin.frequency[:, 1], axis)
        if not resin.in_resin:
            return np.ones((1, 1))
    sigma = levelling_length / FULL_WIDTH
    return np.exp(-2 * (np.pi * sigma * along) ** 2)


def worst_contrast(rules: MaskRules, setting: MoireSetting, pitch: float, ratio: float) -> float:
    """Return the contrast of the strongest beat that mesh or pattern takes part in."""
    beats = find_beats(gratings(rules, setting, pitch, ratio), setting, rules.levelling_length)
    return max((b.contrast for b in beats if {"pattern", "mesh"} & set(b.pair)), default=0.0)


def suggest(
    rules: MaskRules, setting: MoireSetting, pitch: float, ratio: float
) -> tuple[MaskRules, MoireSetting, float]:
    """Return the mesh angle, and pattern angle or period, with the weakest worst beat, and it.

    The mesh is turned in steps of half a degree; then the angle of an angled lattice likewise, or
    the period of another pattern by up to a sixth.
    """
    best = (worst_contrast(rules, setting, pitch, ratio), rules, setting)
    if rules.mesh is not None:
        for angle in np.arange(5, 40.5, 0.5) * deg:
            turned = replace(setting, mesh_angle=float(angle))
            worst = worst_contrast(rules, turned, pitch, ratio)
            best = min(best, (worst, rules, turned), key=lambda entry: entry[0])
    setting = best[2]
    if rules.pattern == "angled":
        choices = [replace(rules, angle=float(a)) for a in np.arange(5, 85.5, 0.5) * deg]
    elif rules.is_stochastic:
        choices = []
    else:
        choices = [replace(rules, period=rules.period * (1 + k / 120)) for k in range(-20, 21)]
    for choice in choices:
        worst = worst_contrast(choice, setting, pitch, ratio)
        if worst < best[0] - 1e-6:
            best = (worst, choice, setting)
    return best[1], best[2], best[0]
