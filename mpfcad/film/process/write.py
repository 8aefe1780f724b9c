"""Write a process calibration from printed and measured coupons: a tone curve, or their table."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mpfcad.boundary.out import asked_file
from mpfcad.errors import InputError
from mpfcad.film.groove import Groove
from mpfcad.film.process.file import read_process
from mpfcad.film.process.model import NORMAL_95
from mpfcad.film.process.posterior import Calibration, FillCoupon, calibrate
from mpfcad.film.process.tone import ToneBelief
from mpfcad.units import um

#: How a calibration that is written here begins.
CALIBRATED = "# Process calibration"
#: Deviation of ln(fill) of a coupon whose trace states none.
UNSTATED_DEVIATION = 0.05


@dataclass(frozen=True)
class Coupon:
    """One print: its aperture ratio, the curvature through the tips that came of it, the trace.

    `low` and `high` are the curvature's 95 % interval; None when it is not known.
    """

    aperture_ratio: float
    curvature: float
    name: str
    low: float | None = None
    high: float | None = None

    def fill(self, groove: Groove) -> FillCoupon:
        """Return the resin that the curvature means, with the deviation of its logarithm."""
        fill = float(groove.fill_fraction(self.curvature))
        deviation = UNSTATED_DEVIATION
        if self.low is not None and self.high is not None and fill > 0:
            ends = (max(0.0, self.low), min(self.high, groove.curvature_empty))
            most, least = (float(groove.fill_fraction(end)) for end in ends)
            deviation = (most - least) / (2 * NORMAL_95 * fill)
        return FillCoupon(self.aperture_ratio, fill, deviation, self.name)


def write_process(path: Path, coupons: Sequence[Coupon], groove: Groove) -> None:
    """Write a `table` calibration; coupons of one aperture ratio become one row, their mean.

    Raises
    ------
    InputError
        when the coupons are fewer than two aperture ratios, or do not grow in fill.
    """
    rows: dict[float, list[Coupon]] = {}
    for coupon in sorted(coupons, key=lambda coupon: coupon.aperture_ratio):
        rows.setdefault(coupon.aperture_ratio, []).append(coupon)
    if len(rows) < 2:
        given = ", ".join(f"{ratio:g}" for ratio in rows)
        raise InputError(f"aperture_ratio: {given}: expected two or more different ones")
    _write(path, _table_document(rows, groove), groove)


def write_tone_process(
    path: Path,
    coupons: Sequence[Coupon],
    groove: Groove,
    prior: ToneBelief,
    screen: dict[str, object] | None = None,
    most: float = np.inf,
) -> Calibration:
    """Write a `tone` calibration, the posterior of coupons, and return it.

    `screen` is what the coupons were printed through, in outside names; None: not stated. `most` is
    the transfer factor at which all that the screen holds leaves it.

    Raises
    ------
    InputError
        when the coupons are fewer than two aperture ratios, are no prints, or surely hold more
        resin than the screen does.
    """
    fills = [coupon.fill(groove) for coupon in coupons]
    found = calibrate(prior, fills)
    factor, deviation = found.belief.transfer_factor, float(found.belief.deviation[0])
    if factor * np.exp(-NORMAL_95 * deviation) > most * (1 + 1e-9):
        raise InputError(
            f"{', '.join(coupon.name for coupon in coupons)}: {factor / most:.0%} of what the mesh "
            "holds would lie in the grooves: expected at most 100 %: --mesh, --solids or "
            "--aperture do not fit these prints"
        )
    _write(path, _tone_document(found, fills, groove, screen), groove)
    return found


def _write(path: Path, document: str, groove: Groove) -> None:
    """Write a calibration that reads back."""
    path = Path(path)
    with asked_file(path) as part:
        part.write_bytes(document.encode())
        try:
            read_process(part, groove)
        except InputError as error:
            raise InputError(str(error).replace(str(part), str(path))) from None


def _tone_document(
    found: Calibration,
    coupons: Sequence[FillCoupon],
    groove: Groove,
    screen: dict[str, object] | None,
) -> str:
    belief, curve = found.belief, found.belief.curve
    deviation = belief.deviation
    correlation = belief.covariance / deviation[:, None] / deviation
    names = ", ".join(coupon.name for coupon in coupons)
    caveats = ["prior: the published tone curve of a half-tone print on paper"]
    if found.birge >= 1.005:
        caveats.append(
            "the coupons scatter more than their intervals explain: all intervals are made "
            f"{found.birge:.3g} times as wide"
        )
    lines = [
        f"{CALIBRATED} from stylus traces of printed coupons (mpfcad calibrate).",
        "schema = 1",
        'kind = "tone"',
        f"source = {json.dumps('stylus traces ' + names, ensure_ascii=False)}",
        f"caveats = {json.dumps(caveats, ensure_ascii=False)}",
        "",
        *_groove_lines(groove),
        "",
        "[tone]                # fill = transfer_factor * tone curve (docs/process.md)",
        f"transfer_factor = {belief.transfer_factor:.9g}",
        f"dead_zone = {curve.dead_zone:.9g}",
        f"contrast = {curve.contrast:.9g}",
        f"gain = {curve.gain:.9g}",
        "# deviations of ln transfer_factor, dead_zone, ln contrast, ln gain, and correlations",
        f"deviation = [{', '.join(f'{value:.6g}' for value in deviation)}]",
        "correlation = [",
        *(f"    [{', '.join(f'{value:.6f}' for value in row)}]," for row in correlation),
        "]",
    ]
    if screen:
        lines += ["", "[screen]              # that the coupons were printed through"]
        lines += [f"{name} = {json.dumps(value)}" for name, value in screen.items()]
    for coupon in sorted(coupons, key=lambda coupon: coupon.aperture_ratio):
        half = NORMAL_95 * coupon.log_deviation * coupon.fill_fraction
        low, high = max(0.0, coupon.fill_fraction - half), coupon.fill_fraction + half
        lines += [
            "",
            "[[coupon]]",
            f"file = {json.dumps(coupon.name, ensure_ascii=False)}",
            f"aperture_ratio = {coupon.aperture_ratio!r}",
            f"fill_fraction = {coupon.fill_fraction:.9g}",
            f"ci95 = [{low:.9g}, {high:.9g}]",
        ]
    return "\n".join(lines) + "\n"


def _groove_lines(groove: Groove) -> list[str]:
    return [
        "[groove]",
        f"pitch_um = {groove.pitch / um:.9g}",
        f"depth_um = {groove.depth / um:.9g}",
    ]


def _table_document(rows: dict[float, list[Coupon]], groove: Groove) -> str:
    names = ", ".join(coupon.name for row in rows.values() for coupon in row)
    lines = [
        f"{CALIBRATED} from stylus traces of printed coupons (mpfcad calibrate).",
        "schema = 1",
        'kind = "table"',
        f"source = {json.dumps('stylus traces ' + names, ensure_ascii=False)}",
        "",
        *_groove_lines(groove),
    ]
    for ratio, row in rows.items():
        mean = sum(coupon.curvature for coupon in row) / len(row)
        lines += ["", "[[row]]", f"aperture_ratio = {ratio!r}", f"curvature_per_mm = {mean:.9g}"]
    return "\n".join(lines) + "\n"
