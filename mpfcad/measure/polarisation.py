"""How the normal light is polarised, and the luminance behind a polariser at any angle."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.contrast.harmonic import vector_length
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.rounds import Lit, TraceRun, TraceState, Watch
from mpfcad.measure.uniformity import middle
from mpfcad.units import deg

if TYPE_CHECKING:
    from mpfcad.optics.source import Source

_FIGURE = "polarisation ± {:.5f}"
#: So many blocks at least tell a standard error well enough for the length of a vector.
_LEAST_BLOCKS = 64
#: Angles [rad] of the polariser from the grooves, anticlockwise as seen by the viewer.
ANGLES = np.arange(0.0, 180.0, 15.0) * deg


@dataclass(frozen=True)
class PolarisationResult:
    """Stokes parameters of the normal light, the mean over a lamp pitch or a cell of LEDs.

    In bands they are those of luminance.

    Attributes
    ----------
    luminance
        [cd/m²] of all light
    along, diagonal, circular
        Q/I, U/I and V/I: light along the grooves less light across them, at 45° less at 135°, and
        of the two circles, as shares of all light
    degree
        √(Q² + U² + V²)/I
    behind
        luminance [cd/m²] behind an ideal polariser at each of `ANGLES`
    by_band
        wavelength [nm] and Q/I of the power in each band, None of one without any; empty without
        bands
    paths
        backward paths traced
    """

    luminance: Estimate
    along: Estimate
    diagonal: Estimate
    circular: Estimate
    degree: Estimate
    behind: tuple[Estimate, ...]
    by_band: tuple[tuple[float, Estimate | None], ...]
    paths: int


def polarisation(lit: Lit, run: TraceRun, error_goal: float) -> PolarisationResult:
    """Return how normal light is polarised, Q/I to a standard error of `error_goal`.

    Raises
    ------
    InputError
        when light is traced without polarisation.
    """
    from mpfcad.optics.source import EYE, Source

    refuse_unpolarised(lit)
    pitch, along = lit.stack.period
    place = middle(lit) + pitch / 2 if lit.is_finite else pitch / 2
    source = Source(
        EYE, np.array([place]), pitch, acceptance=lit.stack.acceptance, spot_along=along
    )
    found = _rounds(lit, source, run, error_goal)
    return replace(read_stokes(found @ _luminous(lit)), by_band=_by_band(lit, found))


def refuse_unpolarised(lit: Lit) -> None:
    """Raise where light is traced without polarisation.

    Raises
    ------
    InputError
        saying what the stack needs.
    """
    if not lit.stack.polarised:
        raise InputError(
            f"{lit.stack.name}: polarisation: needs light.polarised = true in the stack"
        )


def _rounds(lit: Lit, source: "Source", run: TraceRun, goal: float) -> NDArray[np.float64]:
    """Return the mean I, Q, U, V of enough blocks, (b, 4, channels): one without bands."""
    from mpfcad.optics.base.net import NET

    luminous = _luminous(lit)
    found = np.empty((0, 4, len(luminous)))
    error = float("nan")
    while len(found) == 0 or (error > goal and len(found) * NET < run.path_limit):
        more = max(_LEAST_BLOCKS, len(found) // 2)
        watch = Watch(
            run.progress, TraceState(len(found) * NET, run.path_limit, error, goal, _FIGURE), NET
        )
        part = _traced(
            lit, source, more, seed=run.seed, first=len(found), threads=run.threads,
            after_block=watch.block if run.progress else None,
        )  # fmt: skip
        found = np.concatenate([found, part[:, 0]])
        error = read_stokes(found @ luminous).along.standard_error
    return found


def _traced(lit: Lit, source: "Source", blocks: int, **how: Any) -> NDArray[np.float64]:
    """Return the mean I, Q, U, V of blocks and points, (blocks, p, 4, channels)."""
    from mpfcad.optics.spectral.engine import trace_stokes_channels
    from mpfcad.optics.stokes.engine import trace_stokes

    if lit.spectral is not None:
        return trace_stokes_channels(lit.spectral, source, blocks, **how)
    return trace_stokes(lit.scene, source, blocks, **how)[..., None]


def _luminous(lit: Lit) -> NDArray[np.float64]:
    """Return the luminance of what each channel counts, (channels,): 1 without bands."""
    return np.ones(1) if lit.spectral is None else lit.spectral.colour[:, 1]


def _by_band(lit: Lit, found: NDArray[np.float64]) -> tuple[tuple[float, Estimate | None], ...]:
    """Return the wavelength and Q/I of each band, of the power of all channels there."""
    bands = lit.stack.bands
    if bands is None:
        return ()
    part = found.reshape(len(found), 4, -1, bands.count).copy()
    part[:, :, 0] *= bands.source_power
    power = part.sum(axis=2)
    return tuple(
        (wavelength, read_stokes(one).along if one[:, 0].mean() > 0 else None)
        for wavelength, one in zip(bands.wavelength, np.moveaxis(power, -1, 0), strict=True)
    )


def read_stokes(found: NDArray[np.float64]) -> PolarisationResult:
    """Return what the mean I, Q, U, V of independent blocks say, (b, 4) float64 [cd/m²].

    A share Q/I has the error of the mean of (Q - (Q/I) I)/I over the blocks (the ratio estimator's;
    Cochran, "Sampling techniques", 1977).
    """
    from mpfcad.optics.base.net import NET

    blocks = len(found)
    mean = found.mean(axis=0)
    if not mean[0] > 0:
        raise InputError("polarisation: no light reaches the meter: expected some")
    share = mean[1:] / mean[0]
    rest = (found[:, 1:] - share * found[:, :1]) / mean[0]
    covariance = np.cov(rest, rowvar=False) / blocks
    error = np.sqrt(np.diag(covariance))
    along, diagonal, circular = (
        Estimate.student(float(v), float(e), blocks - 1) for v, e in zip(share, error, strict=True)
    )
    return PolarisationResult(
        _mean(found[:, 0]), along, diagonal, circular,
        vector_length(share, covariance, blocks - 1),
        tuple(_mean(_behind(found, angle)) for angle in ANGLES), (), blocks * NET,
    )  # fmt: skip


def _behind(found: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """Return the luminance behind an ideal polariser: ½ (I + Q cos 2a + U sin 2a)."""
    return 0.5 * (found @ (1.0, np.cos(2 * angle), np.sin(2 * angle), 0.0))


def _mean(values: NDArray[np.float64]) -> Estimate:
    """Return the mean of independent blocks."""
    error = float(values.std(ddof=1) / np.sqrt(len(values)))
    return Estimate.student(float(values.mean()), error, len(values) - 1)
