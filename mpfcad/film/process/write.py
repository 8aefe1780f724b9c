"""Write a process calibration from printed and measured coupons."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mpfcad.errors import InputError
from mpfcad.film.groove import Groove
from mpfcad.film.process.file import read_process
from mpfcad.units import um


@dataclass(frozen=True)
class Coupon:
    """One print: its aperture ratio, the curvature through the tips that came of it, the trace."""

    aperture_ratio: float
    curvature: float
    name: str


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
        raise InputError(f"aperture_ratio: {given}: allowed two or more different ones")
    path = Path(path)
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(_document(rows, groove).encode())
        read_process(part, groove)
        part.replace(path)
    except InputError as error:
        raise InputError(str(error).replace(str(part), str(path))) from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        part.unlink(missing_ok=True)


def _document(rows: dict[float, list[Coupon]], groove: Groove) -> str:
    names = ", ".join(coupon.name for row in rows.values() for coupon in row)
    lines = [
        "# Process calibration from stylus traces of printed coupons (mpfcad calibrate).",
        "schema = 1",
        'kind = "table"',
        f"source = {json.dumps('stylus traces ' + names, ensure_ascii=False)}",
        "",
        "[groove]",
        f"pitch_um = {groove.pitch / um:.9g}",
        f"depth_um = {groove.depth / um:.9g}",
    ]
    for ratio, row in rows.items():
        mean = sum(coupon.curvature for coupon in row) / len(row)
        lines += ["", "[[row]]", f"aperture_ratio = {ratio!r}", f"curvature_per_mm = {mean:.9g}"]
    return "\n".join(lines) + "\n"
