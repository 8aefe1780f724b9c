"""The printing process: aperture ratio <-> fill fraction <-> curvature.

Resin pressed through the apertures fills the grooves, so fill_fraction is a growing function of
aperture_ratio with fill(0) = 0. It is kept as straight lines between knots, whose inverse is exact:

* `volume`: fill_fraction = transfer_factor · aperture_ratio;
* `table`: measured rows;
* `tone`: transfer_factor · tone curve (`tone.py`), with what is not known of it.

All end where the groove is full (fill 1; of diluted resin: full of what was printed) or at the last
row. The resin laid down per area does not
depend on the groove, so a calibration made in a groove of depth d0 is scaled by d0/depth.
"""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError
from mpfcad.film.groove import Groove
from mpfcad.film.process.tone import PARAMETERS, ToneBelief

ProcessKind = Literal["volume", "table", "tone"]
#: Standard deviations to either side of a 95 % interval.
NORMAL_95 = 1.959963984540054
#: A mode of the fill's error below this share of the largest one is left out: it widens an interval
#: by less than 5 %.
LEAST_MODE = 0.3


@dataclass(frozen=True, eq=False)
class Process:
    """A calibrated printing process for one groove.

    The methods do not validate; `check_printable` does, at the boundary.

    Attributes
    ----------
    groove
        the groove that is printed into
    kind
        `volume` or `table`
    knot_ratio, knot_fill
        (m,) float64, aperture ratios and fill fractions 0…1, both increasing from 0
    source
        where the calibration comes from
    caveats
        what its user has to know
    belief
        transfer factor and tone curve with their covariance; None unless the kind is `tone`
    log_deviation
        standard deviation of ln(fill) at all ratios, besides the belief's; None: not known
    screen
        what of the screen the process holds for, in outside names; empty: not stated
    """

    groove: Groove
    kind: ProcessKind
    knot_ratio: NDArray[np.float64]
    knot_fill: NDArray[np.float64]
    source: str
    caveats: tuple[str, ...] = field(default=())
    belief: ToneBelief | None = None
    log_deviation: float | None = None
    screen: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def build(
        cls,
        groove: Groove,
        kind: ProcessKind,
        ratio: ArrayLike,
        fill: ArrayLike,
        source: str,
        caveats: tuple[str, ...] = (),
        *,
        full: float = 1.0,
    ) -> "Process":
        """Return the process with given knots, (0, 0) put before and cut where fill is `full`."""
        ratio, fill = np.array(ratio, float), np.array(fill, float)
        if ratio[0] > 0:
            ratio, fill = np.append(0.0, ratio), np.append(0.0, fill)
        if fill[-1] > full:
            last = np.interp(full, fill, ratio)
            ratio, fill = np.append(ratio[fill < full], last), np.append(fill[fill < full], full)
        ratio.flags.writeable = fill.flags.writeable = False
        return cls(groove, kind, ratio, fill, source, caveats)

    @classmethod
    def build_tone(
        cls,
        groove: Groove,
        belief: ToneBelief,
        source: str,
        caveats: tuple[str, ...] = (),
        *,
        solids_fraction: float = 1.0,
        screen: dict[str, Any] | None = None,
    ) -> "Process":
        """Return the process of a tone curve; its transfer factor is that of the dried resin.

        Of resin diluted to `solids_fraction` the groove is full of what was printed when the dried
        fill is that fraction.
        """
        curve, factor = belief.curve, belief.transfer_factor
        share = np.union1d(np.geomspace(1e-6, 1, 1500), np.linspace(0, 1, 1501))
        ratio, fill = curve.aperture_ratio(share), factor * share
        top = solids_fraction
        if fill[-1] > top:
            full = float(curve.aperture_ratio(top / factor))
            ratio, fill = np.append(ratio[fill < top], full), np.append(fill[fill < top], top)
        ratio.flags.writeable = fill.flags.writeable = False
        return cls(
            groove, "tone", ratio, fill, source, caveats, belief, None, dict(screen or {})
        )  # fmt: skip

    @property
    def transfer_factor(self) -> float | None:
        """Fill fraction at aperture ratio 1, could the groove hold it; None for a table."""
        if self.belief is not None:
            return self.belief.transfer_factor
        return float(self.knot_fill[1] / self.knot_ratio[1]) if self.kind == "volume" else None

    @property
    def aperture_ratio_max(self) -> float:
        """Largest useful aperture ratio: the groove is full, or the calibration ends."""
        return float(self.knot_ratio[-1])

    @property
    def fill_fraction_max(self) -> float:
        """Largest fill fraction that the process reaches."""
        return float(self.knot_fill[-1])

    @property
    def curvature_min(self) -> float:
        """Smallest curvature [1/mm] that the process reaches."""
        return float(self.groove.curvature_of_fill(self.fill_fraction_max))

    def fill_fraction(self, aperture_ratio: ArrayLike) -> NDArray[np.float64]:
        """Return the fill fraction, 0…1, that an aperture ratio gives."""
        return np.interp(np.asarray(aperture_ratio, float), self.knot_ratio, self.knot_fill)

    def aperture_ratio(self, fill_fraction: ArrayLike) -> NDArray[np.float64]:
        """Return the aperture ratio that a fill fraction needs."""
        return np.interp(np.asarray(fill_fraction, float), self.knot_fill, self.knot_ratio)

    def curvature(self, aperture_ratio: ArrayLike) -> NDArray[np.float64]:
        """Return the curvature [1/mm] through the tips that an aperture ratio gives."""
        return self.groove.curvature_of_fill(self.fill_fraction(aperture_ratio))

    def aperture_ratio_of_curvature(self, curvature: ArrayLike) -> NDArray[np.float64]:
        """Return the aperture ratio that a curvature [1/mm] through the tips needs."""
        return self.aperture_ratio(self.groove.fill_fraction(curvature))

    def fill_deviation(self, aperture_ratio: ArrayLike) -> NDArray[np.float64] | None:
        """Return the standard deviation of ln(fill) at aperture ratios; None when not known."""
        ratio = np.atleast_1d(np.asarray(aperture_ratio, float))
        if self.belief is not None:
            return self.belief.log_deviation(ratio)
        return None if self.log_deviation is None else np.full(ratio.shape, self.log_deviation)

    def fill_modes(self, aperture_ratio: ArrayLike) -> NDArray[np.float64] | None:
        """Return what is not known of the print as modes, (k, n) float64; None when not known.

        ln fill of n ratios = that of the mean + Σ z_k mode_k with independent standard normal z:
        principal axes of its covariance. The first is how all fills go up and down together, the
        second how large ratios go against small ones. Modes below `LEAST_MODE` of the first are
        left out.
        """
        ratio = np.atleast_1d(np.asarray(aperture_ratio, float))
        if self.belief is not None:
            root = self.belief.log_root(ratio)
        elif self.log_deviation is not None:
            root = np.full((len(ratio), 1), self.log_deviation)
        else:
            return None
        left, size, _ = np.linalg.svd(root, full_matrices=False)
        kept = max(1, int(np.sum(size > LEAST_MODE * size[0])))
        modes = (left * size).T[:kept]
        return modes * np.where(modes.sum(axis=1, keepdims=True) < 0, -1.0, 1.0)

    def curvature_interval(
        self, aperture_ratio: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Return the 95 % interval of the curvature [1/mm] that ratios give; None: not known."""
        deviation = self.fill_deviation(aperture_ratio)
        if deviation is None:
            return None
        fill = self.fill_fraction(aperture_ratio)
        low, high = (np.clip(fill * np.exp(s * NORMAL_95 * deviation), 0, 1) for s in (1, -1))
        return self.groove.curvature_of_fill(low), self.groove.curvature_of_fill(high)

    def describe(self) -> dict[str, Any]:
        """Return the calibration in outside names, fit for JSON."""
        described: dict[str, Any] = {"kind": self.kind}
        if self.belief is not None:
            described["transfer_factor"] = self.transfer_factor
            described["tone"] = describe_belief(self.belief)
        elif self.kind == "volume":
            described["transfer_factor"] = self.transfer_factor
        else:
            curvature = self.groove.curvature_of_fill(self.knot_fill)
            columns = {
                "aperture_ratio": self.knot_ratio,
                "fill_fraction": self.knot_fill,
                "curvature_per_mm": curvature,
                "fitted_curvature_per_mm": self.groove.fitted_curvature(curvature),
            }
            described["table"] = [
                {name: float(values[i]) for name, values in columns.items()}
                for i in range(len(curvature))
            ]
        return described | {
            "aperture_ratio_max": self.aperture_ratio_max,
            "fill_fraction_max": self.fill_fraction_max,
            "curvature_min_per_mm": self.curvature_min,
            "source": self.source,
            "caveats": list(self.caveats),
            "screen": self.screen or None,
        }


def describe_belief(belief: ToneBelief) -> dict[str, Any]:
    """Return a belief in outside names: each parameter's value and 95 % interval."""
    described = {}
    for i, name in enumerate(PARAMETERS):
        ends = [belief.mean[i] + s * NORMAL_95 * belief.deviation[i] for s in (0, -1, 1)]
        if name.startswith("ln_"):
            ends = [np.exp(end) for end in ends]
        value, low, high = (float(end) for end in ends)
        described[name.removeprefix("ln_")] = {"value": value, "ci95": [low, high]}
    return described


def groove_ranges(index: ArrayLike, most: int = 6) -> str:
    """Return groove numbers (increasing) as text: `grooves 12-40, 600-612`."""
    index = np.asarray(index, int)
    cut = np.flatnonzero(np.diff(index) > 1) + 1
    runs = np.split(index, cut)
    names = [f"{r[0]}" if len(r) == 1 else f"{r[0]}-{r[-1]}" for r in runs[:most]]
    if len(runs) > most:
        names.append(f"… ({len(index)} in all)")
    return ("groove " if len(index) == 1 else "grooves ") + ", ".join(names)


def check_printable(process: Process, curvature: ArrayLike, where: str) -> None:
    """Refuse curvatures [1/mm], one a groove, that the process cannot reach.

    Raises
    ------
    InputError
        that begins with `where` and names the grooves, counted from 0.
    """
    curvature = np.atleast_1d(np.asarray(curvature, float))
    fill = process.groove.fill_fraction(curvature)
    bad = np.flatnonzero(
        ~(fill <= process.fill_fraction_max * (1 + 1e-12))
        | ~(curvature <= process.groove.curvature_empty * (1 + 1e-12))
    )
    if bad.size:
        needed = float(fill[bad].max())
        raise InputError(
            f"{where}: {groove_ranges(bad)}: curvature_per_mm "
            f"{curvature[bad].min():.4g} … {curvature[bad].max():.4g}: expected "
            f"{process.curvature_min:.4g} … {process.groove.curvature_empty:.4g}, "
            f"what the process reaches (fill 0 … {process.fill_fraction_max:.4g}), or a "
            f"process.calibration or mask.mesh that fills {needed:.4g}, or film.profile = 'ideal'"
        )


def check_aperture_ratio(process: Process, aperture_ratio: ArrayLike, where: str) -> None:
    """Refuse aperture ratios outside what the process is calibrated for.

    Raises
    ------
    InputError
        that begins with `where`.
    """
    ratio = np.atleast_1d(np.asarray(aperture_ratio, float))
    top = process.aperture_ratio_max
    bad = ratio[~((ratio >= 0) & (ratio <= top * (1 + 1e-12)))]
    if bad.size:
        raise InputError(
            f"{where}: aperture_ratio {bad[0]:g}: expected 0 … {top:.4g} (there the groove's fill "
            f"is {process.fill_fraction_max:.4g})"
        )
