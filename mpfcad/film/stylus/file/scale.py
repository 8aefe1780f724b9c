"""Unit and scale of a trace against the pitch and depth that its grooves are known to have.

A trace of V grooves with bare walls tells its own scale: the walls' slope. One whose resin covers
the walls is a parabola between tips at any scale; there only the relief can be wrong by far.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.dilated import DilatedGroove
from mpfcad.film.stylus.file.unit import UNITS, USUAL
from mpfcad.film.stylus.tip import StylusTip
from mpfcad.units import um

#: Share of the variance that a period must explain.
SHOWN = 0.5
#: Pitch and scale may be off by so much and still be the film's or the instrument's.
TOLERANCE = 0.12
#: A relief below this share of the depth is that of another unit.
FLATTEST = 0.02
#: And above this one, by profile: a mould's parabola may dip below the walls' valley.
MOST_RELIEF: dict[Profile, float] = {"filled": 1.2, "ideal": 2.5}
#: Points that are looked at.
_POINTS = 1500
#: Tips tried.
_TIPS = (None, StylusTip(2 * um), StylusTip(5 * um), StylusTip(12.5 * um))


@dataclass(frozen=True)
class Shape:
    """What a trace shows, in its own numbers times the factors it was read with.

    Attributes
    ----------
    explained
        share of the trace's variance that grooves of this pitch explain
    pitch
        [mm]
    gain
        heights over those of the bare walls' slope; None where no wall is bare
    relief
        [mm], from tip to valley
    """

    explained: float
    pitch: float
    gain: float | None
    relief: float


def read_shape(
    x: NDArray[np.float64],
    z: NDArray[np.float64],
    groove: Groove,
    profile: Profile = "filled",
    tip: StylusTip | None = None,
) -> Shape:
    """Return the grooves of about `groove.pitch` that a trace (n,) [mm] shows."""
    stride = max(1, len(x) // _POINTS)
    x, z = x[::stride] - x[0], z[::stride]
    z = z - np.median(z)
    limit = 6 * np.median(np.abs(z - np.median(z)))
    if limit > 0:
        z = np.clip(z, -limit, limit)  # a spike must not decide
    steps = max(9, 2 * int(4 * TOLERANCE * (x[-1] / groove.pitch)) + 9)
    pitches = groove.pitch * np.linspace(1 - TOLERANCE, 1 + TOLERANCE, steps)
    waves = [_explained(x, z, p) for p in pitches]
    best = int(np.argmax([share for share, _ in waves]))
    share, phase = waves[best]
    pitch = float(pitches[best])
    centre = (phase / (2 * np.pi) + 0.5) * pitch
    # A stated tip too: a file may name one that did not trace it.
    tips = (*_TIPS, tip) if tip else _TIPS
    # The first harmonic puts the tips where the trace is high; upside down they are low.
    _, gain, bare, relief = min(
        _fit_shape(x, z, DilatedGroove(groove, profile, t), pitch, centre + turn)
        for t in tips
        for turn in (0.0, pitch / 2)
    )
    return Shape(share, pitch, gain if bare else None, relief)


def _explained(x: NDArray[np.float64], z: NDArray[np.float64], pitch: float) -> tuple[float, float]:
    """Return the share of variance of three harmonics of a pitch, and the first one's phase."""
    base = _base(x)
    angle = 2 * np.pi * x / pitch
    waves = [f(k * angle) for k in (1, 2, 3) for f in (np.cos, np.sin)]
    full = np.column_stack([base, *waves])
    flat = z - base @ np.linalg.lstsq(base, z, rcond=None)[0]
    weight = np.linalg.lstsq(full, z, rcond=None)[0]
    left = z - full @ weight
    total = float(np.sum(flat**2))
    at = base.shape[1]
    if total == 0:
        return 0.0, 0.0
    return 1 - float(np.sum(left**2)) / total, float(np.arctan2(weight[at + 1], weight[at]))


def _base(x: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([np.ones_like(x), x, x**2], axis=1)


def _fit_shape(
    x: NDArray[np.float64],
    z: NDArray[np.float64],
    traced: DilatedGroove,
    pitch: float,
    centre: float,
) -> tuple[float, float, bool, float]:
    """Return the residual's variance, gain, whether walls are bare, and relief, best over C.

    The model is base + gain · profile of a groove of slope s/w stretched to the pitch; a gain of
    either sign, the sign taken off.
    """
    groove, profile = traced.groove, traced.profile
    local = ((x - centre) / pitch + 0.5) % 1 - 0.5
    base = _base(x)
    most = groove.curvature_empty if profile == "filled" else groove.curvature_covered
    tried = np.linspace(groove.curvature_covered, most, 17) if profile == "filled" else [most]
    best: tuple[float, float, bool, float] | None = None
    stretch = pitch / groove.pitch
    for curvature in tried:
        shape = traced.height(groove.pitch * local, float(curvature)) * stretch
        full = np.column_stack([base, shape])
        weight = np.linalg.lstsq(full, z, rcond=None)[0]
        left = float(np.var(z - full @ weight))
        gain = abs(float(weight[-1]))
        relief = gain * stretch * float(groove.depth - groove.vertex_height(curvature).clip(0))
        if best is None or left < best[0]:
            bare = curvature > groove.curvature_covered * 1.1
            best = (left, gain, bare, relief)
    assert best is not None
    return best


def fitting_units(
    x: NDArray[np.float64],
    z: NDArray[np.float64],
    groove: Groove,
    profile: Profile,
    tip: StylusTip | None = None,
) -> list[tuple[str, str]]:
    """Return the pairs of units of position and height in which a trace shows such grooves."""
    pairs = []
    for x_name in USUAL:
        x_factor = UNITS[x_name]
        length = (x[-1] - x[0]) * x_factor
        if not 1.5 * groove.pitch <= length < 1e5 * groove.pitch:
            continue
        step = float(np.median(np.diff(x))) * x_factor
        if step > groove.pitch / 6:
            continue
        for z_name in USUAL:
            shape = read_shape(x * x_factor, z * UNITS[z_name], groove, profile, tip)
            if shape.explained < SHOWN:
                break
            if is_plausible(shape, groove, profile):
                pairs.append((x_name, z_name))
    return pairs


def is_plausible(shape: Shape, groove: Groove, profile: Profile) -> bool:
    """Return whether heights are of the grooves' size, as far as their shape can tell."""
    if shape.gain is not None and not 0.5 < shape.gain < 2:
        return False
    return FLATTEST * groove.depth < shape.relief < groove.depth * MOST_RELIEF[profile]


def relief_of(x: NDArray[np.float64], z: NDArray[np.float64]) -> float:
    """Return how far heights (n,) [mm] reach about a parabola, a few spikes left out."""
    base = _base((x - x[0]) / np.ptp(x))
    flat = z - base @ np.linalg.lstsq(base, z, rcond=None)[0]
    return float(np.subtract(*np.percentile(flat, [98, 2])))
