"""A film in its backlight looked at by a renderer: this program's tracer, or Mitsuba."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mpfcad.measure import POINTS

#: Places over a lamp pitch, from lamp to lamp.
PLACES = np.linspace(0, 1, POINTS)


@dataclass(frozen=True)
class Seen:
    """Luminance and standard error [cd/m²] at places [pitch] from lamp to lamp."""

    position: np.ndarray
    luminance: np.ndarray
    error: np.ndarray

    @property
    def mean(self):
        """Mean luminance over the pitch and its standard error; both ends are one place."""
        weight = np.ones(len(self.position))
        weight[[0, -1]] = 0.5
        weight /= weight.sum()
        return float(weight @ self.luminance), float(np.linalg.norm(weight * self.error))

    def over(self, other):
        """Return the mean over another's, and the standard error."""
        (value, error), (base, wrong) = self.mean, other.mean
        return value / base, value / base * float(np.hypot(error / value, wrong / base))

    def contrast(self):
        """Return the lamp-Mura contrast as the program reads it off noisy points."""
        from mpfcad.measure import contrast_of_curve, fit_curve

        return contrast_of_curve(fit_curve(self.position, self.luminance, self.error))


def look(renderer, lit, mesh, offset, paths, seed, lamps=1):
    """Return what a renderer shows of a scene; `mesh`, `offset` [mm]: its film, for the other one.

    lamps: an odd number that Mitsuba's row has, more than one where the film is not its own mirror
    image about a lamp.
    """
    if renderer == "own":
        return _own(lit, paths, seed)
    from tracer.mitsuba_curve import curve

    meter = lit.spot.width, lit.stack.acceptance
    return Seen(PLACES, *curve(lit.elements, mesh, offset, meter, PLACES, paths, seed, lamps))


def _own(lit, paths, seed):
    from mpfcad.measure.rounds import trace_lit
    from mpfcad.optics.engine import BLOCK
    from mpfcad.optics.source import EYE, Source
    from mpfcad.pipeline.effort import available_threads

    source = Source(
        EYE, PLACES * lit.stack.period.across, lit.spot.width, acceptance=lit.stack.acceptance
    )
    blocks = max(8, round(paths / (len(PLACES) * BLOCK)))
    tally = trace_lit(lit, source, blocks, seed=seed, threads=available_threads())
    return Seen(PLACES, tally.radiance, tally.radiance_error)


def write_seen(seen: Seen, pitch: float, file: Path) -> None:
    """Write what was seen as a meter's table of places, luminances and their errors."""
    rows = zip(seen.position * pitch, seen.luminance, seen.error, strict=True)
    lines = [f"{x:.4f},{value:.3f},{error:.3f}" for x, value, error in rows]
    head = "position_mm,luminance_cd_m2,standard_error"
    file.write_text("\n".join([head, *lines, ""]), "utf-8")
