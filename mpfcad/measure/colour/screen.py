"""The colour of a screen: over what repeats, and over direction."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.cell.tracer import can_connect, cell_scale
from mpfcad.measure.colour.chromaticity import (
    Colour,
    colour_of,
    difference,
    points_of,
)
from mpfcad.measure.colour.mura import colour_mura
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.judged import judged_pitches
from mpfcad.measure.meter import POINTS, pitch_positions
from mpfcad.measure.rounds import Lit, TraceRun, TraceState, Watch

if TYPE_CHECKING:
    from mpfcad.optics.source import Source

#: Parts of a cell of LEDs along each axis.
PARTS = 8
#: Polar angles [rad] of each cut, across the lamps and along them.
ANGLES = np.radians(np.arange(-80, 81, 10))
_PITCH = "colour ± {:.5f} in u'v'"
#: So many blocks at least tell a standard error well enough for the length of a vector.
_LEAST_BLOCKS = 64


@dataclass(frozen=True, eq=False)
class Places:
    """Colours of some points; p points.

    Attributes
    ----------
    uv, error
        (p, 2) float64, u', v' and their standard errors
    luminance
        (p,) float64 [cd/m²]
    freedom
        degrees of freedom of the errors
    """

    uv: NDArray[np.float64]
    error: NDArray[np.float64]
    luminance: NDArray[np.float64]
    freedom: int


@dataclass(frozen=True, eq=False)
class ColourResult:
    """Colour of the normal light over a lamp pitch or a cell, and over direction.

    Attributes
    ----------
    position
        (p, 2) float64 [mm], where the points lie, x and y; over a pitch y is 0
    over_screen, mean
        colours of these points; that of all their light
    mura
        largest Δu'v' between a point and the mean
    power
        (b,) float64, the light's power in each band over all of it
    along, across
        colours over `ANGLES`, the mean over what repeats; None where directions were not traced
    shift
        Δu'v' from the normal at each of `ANGLES`, across and then along
    paths
        traced: backward, and over a cell of LEDs forward
    """

    position: NDArray[np.float64]
    over_screen: Places
    mean: Colour
    mura: Estimate
    power: NDArray[np.float64]
    across: Places | None
    along: Places | None
    shift: tuple[Estimate, ...]
    paths: int


def refuse_uncoloured(lit: Lit) -> None:
    """Raise where a stack states no bands.

    Raises
    ------
    InputError
        saying what the stack needs.
    """
    if lit.spectral is None:
        raise InputError(f"{lit.stack.name}: colour: needs light.bands and light.spectrum")


def screen_colour(
    lit: Lit, run: TraceRun, error_goal: float, *, directions: bool = True
) -> ColourResult:
    """Return the colour over the screen, to a standard error of `error_goal` in u' and v'.

    It is the mean over a point's spot; `directions`: the colour over direction as well. On a finite
    panel all judged pitches are measured. The result does not depend on the number of threads.

    Raises
    ------
    InputError
        when the stack states no bands, or no light reaches a point.
    """
    refuse_uncoloured(lit)
    source = _over_cell(lit) if lit.is_cell else _over_pitch(lit)
    forward = lit.is_cell and can_connect(lit)
    channels = _rounds(lit, source, run, error_goal, forward=forward)
    xyz = channels @ _colour(lit)
    mean = xyz.mean(axis=1)
    across = along = None
    shift: list[Estimate] = []
    paths = len(channels) * _size(source, forward)
    if directions:
        seen = _rounds(lit, _over_directions(lit), run, error_goal) @ _colour(lit)
        n = len(ANGLES)
        across, along = (_places(seen[:, part]) for part in (slice(0, n), slice(n, 2 * n)))
        shift = [difference(seen[:, i], seen[:, i - i % n + n // 2]) for i in range(2 * n)]
        paths += len(seen) * 2 * n * _net()
    return ColourResult(
        np.column_stack([source.position, source.along]), _places(xyz), colour_of(mean),
        colour_mura(xyz, run.seed), _power(lit, channels), across, along, tuple(shift),
        paths,
    )  # fmt: skip


def _net() -> int:
    from mpfcad.optics.base.net import NET

    return NET


def _colour(lit: Lit) -> NDArray[np.float64]:
    assert lit.spectral is not None  # refused before
    return lit.spectral.colour


def _places(xyz: NDArray[np.float64]) -> Places:
    uv, error = points_of(xyz)
    return Places(uv, error, xyz.mean(axis=0)[:, 1], len(xyz) - 1)


def _power(lit: Lit, channels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the share of each band in the power of the light that reaches the meter."""
    bands = lit.stack.bands
    assert bands is not None  # refused before
    part = channels.mean(axis=(0, 1)).reshape(-1, bands.count)
    power = part[0] * bands.source_power + part[1:].sum(axis=0)
    return power / power.sum()


def _over_pitch(lit: Lit) -> "Source":
    """Return meters over a lamp pitch, or over all judged pitches of a finite panel."""
    from mpfcad.optics.source import EYE, Source

    stack = lit.stack
    position = pitch_positions(stack)
    judged = judged_pitches(stack, position)
    if judged is not None:
        step = POINTS - 1
        position = position[judged.first * step : judged.stop * step + 1]
    return Source(EYE, position * stack.period.across, lit.spot.width, acceptance=stack.acceptance)


def _over_cell(lit: Lit) -> "Source":
    """Return meters over the parts of a cell of LEDs, each of its part's size."""
    from mpfcad.optics.source import EYE, Source

    period = lit.stack.period
    middle = (np.arange(PARTS) + 0.5) / PARTS - 0.5
    x, y = np.meshgrid(middle * period.across, middle * period.along, indexing="ij")
    return Source(
        EYE, x.ravel(), period.across / PARTS, acceptance=lit.stack.acceptance, along=y.ravel(),
        spot_along=period.along / PARTS,
    )  # fmt: skip


def _over_directions(lit: Lit) -> "Source":
    """Return meters of what repeats as a whole, which look along `ANGLES` in both cuts."""
    from mpfcad.optics.source import EYE, Source

    pitch, sine = lit.stack.period.across, -np.sin(ANGLES)
    zero = np.zeros_like(sine)
    return Source(
        EYE, np.full(2 * len(ANGLES), pitch / 2), pitch, np.concatenate([sine, zero]),
        np.concatenate([zero, sine]), lit.stack.acceptance,
    )  # fmt: skip


def _size(source: "Source", forward: bool) -> int:
    """Return how many paths a block of the meters' has."""
    if forward:
        from mpfcad.optics.forward.engine import BLOCK

        return BLOCK
    return len(source.position) * _net()


def _rounds(
    lit: Lit, source: "Source", run: TraceRun, goal: float, *, forward: bool = False
) -> NDArray[np.float64]:
    """Return the channels of enough blocks, (b, p, channels), for the points' mean square error.

    `forward`: those of the parts of a cell, of paths from its LEDs.
    """
    spectral = lit.spectral
    assert spectral is not None  # refused before
    size = _size(source, forward)
    found = np.empty((0, len(source.position), len(spectral.colour)))
    error = float("nan")
    while len(found) == 0 or (error > goal and len(found) * size < run.path_limit):
        more = range(len(found), len(found) + max(_LEAST_BLOCKS, len(found) // 2))
        state = TraceState(len(found) * size, run.path_limit, error, goal, _PITCH)
        after = Watch(run.progress, state, size).block if run.progress else None
        trace = _of_parts if forward else _of_points
        found = np.concatenate([found, trace(lit, source, more, run, after)])
        xyz = found @ spectral.colour
        if not (xyz.mean(axis=0)[:, 1] > 0).all():
            raise InputError(f"{lit.stack.name}: colour: no light reaches a point: expected some")
        error = float(np.sqrt(np.mean(points_of(xyz)[1] ** 2)))
    return found


def _of_points(
    lit: Lit, source: "Source", blocks: range, run: TraceRun, after: Callable[[], None] | None
) -> NDArray[np.float64]:
    """Return the channels that meters see, (b, p, channels)."""
    from mpfcad.optics.spectral.engine import trace_channels

    assert lit.spectral is not None  # refused before
    return trace_channels(
        lit.spectral, source, len(blocks), seed=run.seed, first=blocks.start, threads=run.threads,
        after_block=after,
    )  # fmt: skip


def _of_parts(
    lit: Lit, source: "Source", blocks: range, run: TraceRun, after: Callable[[], None] | None
) -> NDArray[np.float64]:
    """Return the channels of the parts of a cell, (b, p, channels), of paths from its LEDs."""
    from mpfcad.optics.forward.connection import CellMeter
    from mpfcad.optics.forward.engine import BLOCK, trace_parts

    assert lit.spectral is not None  # refused before
    meter = CellMeter(lit.stack.acceptance, *lit.stack.period, PARTS)
    found = trace_parts(
        lit.spectral, meter, blocks, seed=run.seed, threads=run.threads, after_block=after
    )
    return cell_scale(lit, meter) * PARTS**2 / BLOCK * found
