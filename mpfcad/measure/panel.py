"""The luminance of the whole panel, with its corners: a map of cells over a finite backlight."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.estimate import Estimate, estimate_sum
from mpfcad.measure.rounds import Lit, TraceRun, relative_error, trace_rounds
from mpfcad.measure.uniformity import middle

#: Cells across the lamps for each lamp, and along them over the panel.
CELLS_A_LAMP, CELLS_ALONG = 4, 24
_FIGURE = "cell ± {:.4f} of the mean"


@dataclass(frozen=True, eq=False)
class PanelResult:
    """Normal luminance of cells that cover the panel, each averaged over itself.

    Attributes
    ----------
    across, along
        (n,), (24,) float64 [mm], the cells' middles from the panel's left and near edge
    luminance, standard_error
        (n, 24) float64 [cd/m²]
    corner
        luminance of the four corner cells over the middle's: left near, left far, right near, right
        far; the middle is a lamp pitch of cells by two
    paths
        backward paths traced
    """

    across: NDArray[np.float64]
    along: NDArray[np.float64]
    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    corner: tuple[Estimate, Estimate, Estimate, Estimate]
    paths: int


def check_finite(lit: Lit) -> None:
    """Refuse to look for corners where there are none.

    Raises
    ------
    InputError
        when the stack repeats without end.
    """
    if not lit.is_finite:
        raise InputError(
            f"{lit.stack.name}: extent: {lit.stack.extent}: expected panel to measure the panel"
        )


def panel_luminance(lit: Lit, run: TraceRun, error_goal: float) -> PanelResult:
    """Return the map of a finite panel; `error_goal`: of a cell, relative, root mean square.

    Raises
    ------
    InputError
        when the stack repeats without end.
    """
    from mpfcad.optics.source import EYE, Source

    check_finite(lit)
    stack = lit.stack
    n, m = CELLS_A_LAMP * stack.source.count, CELLS_ALONG
    width, length = stack.panel_width / n, stack.panel_length / m
    across, along = np.arange(0.5, n) * width, np.arange(0.5, m) * length
    source = Source(
        EYE,
        middle(lit) - stack.panel_width / 2 + np.repeat(across, m),
        width,
        acceptance=stack.acceptance,
        along=np.tile(along, n) - stack.panel_length / 2,
        spot_along=length,
    )
    tally = trace_rounds(lit, source, run, relative_error, error_goal, _FIGURE)
    value, error = tally.radiance.reshape(n, m), tally.radiance_error.reshape(n, m)
    a, b, c, d = (_over_middle(value, error, tally.blocks, i, k) for i in (0, -1) for k in (0, -1))
    return PanelResult(across, along, value, error, (a, b, c, d), tally.total_paths)


def _over_middle(value: NDArray, error: NDArray, blocks: int, i: int, k: int) -> Estimate:
    """Return a corner's luminance over the middle's; its error is that of the linear part."""
    n, m = (size // 2 for size in value.shape)
    half = CELLS_A_LAMP // 2
    part = (slice(n - half, n + half), slice(m - 1, m + 1))
    centre = value[part].mean()
    share = float(value[i, k] / centre)
    weight = np.zeros(value.shape)
    weight[part] = -share / (centre * value[part].size)
    weight[i, k] = 1 / centre
    # The weighted sum itself is 0: the corner less its share of the middle.
    off = estimate_sum(weight.ravel(), value.ravel(), error.ravel(), blocks)
    return Estimate(share, share + off.low, share + off.high, off.standard_error)
