"""The calibration file of `mpfcad calibrate`: which model, through which screen, how sure."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mpfcad.film import Coupon, Groove


def write_calibration(
    out: Path,
    coupons: "Sequence[Coupon]",
    groove: "Groove",
    model: str,
    mesh: str | None,
    emulsion_um: float,
    solids: float,
) -> dict[str, Any]:
    """Write the calibration; return it in outside names.

    Raises
    ------
    InputError
        for an unknown model or mesh, a solids fraction outside 0…1, or coupons that say too little.
    """
    from mpfcad.errors import InputError
    from mpfcad.film import PRIOR_RELEASE, prior_belief, write_process, write_tone_process
    from mpfcad.film import read_process as read
    from mpfcad.mask.fabric import find_mesh
    from mpfcad.units import um

    if model not in ("tone", "table"):
        raise InputError(f"--model: {model!r}: expected tone or table")
    if not 0 < solids <= 1:
        raise InputError(f"--solids: {solids:g}: expected above 0, up to 1")
    if model == "table":
        write_process(out, coupons, groove)
        return read(out, groove).describe()
    factor, screen, most = None, None, float("inf")
    if mesh is not None:
        fabric = find_mesh(mesh, emulsion=emulsion_um * um, where="--mesh")
        factor = solids * fabric.transfer_factor(groove, PRIOR_RELEASE)
        most = solids * fabric.transfer_factor(groove, 1.0)
        screen = {
            "mesh": fabric.name,
            "volume_cm3_m2": round(fabric.volume / um, 6),
            "solids_fraction": solids,
        }
    found = write_tone_process(out, coupons, groove, prior_belief(factor), screen, most)
    return read(out, groove).describe() | {"scatter_ratio": found.birge}


def print_calibration(process: dict[str, Any]) -> None:
    """Print a tone curve's parameters with their intervals."""
    for name, entry in process.get("tone", {}).items():
        low, high = entry["ci95"]
        print(f"{name:<18}{entry['value']:>9.4f} [{low:.4f}, {high:.4f}]")
