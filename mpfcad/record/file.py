"""What the files of an export hold, in outside names and plain values."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.cad.check.library import LibraryCheck
from mpfcad.mask import MaskCheck
from mpfcad.units import deg, um


@dataclass(frozen=True)
class ResinCheck:
    """The resin of the piece, by the masks and in the mesh; volumes in mm³.

    Attributes
    ----------
    by_mask
        what each mask file gives, by its name: aperture ratios read back, through the process, over
        the area of the piece
    in_mesh
        volume of film.stl less that of the bare prisms
    full
        of grooves filled to their tips
    """

    by_mask: Mapping[str, float]
    in_mesh: float
    full: float

    @property
    def difference(self) -> float:
        """Largest difference between a mask and the mesh, as a share of full grooves."""
        return max(abs(volume - self.in_mesh) for volume in self.by_mask.values()) / self.full


def describe_masks(
    checks: Mapping[str, MaskCheck], curvature: dict[str, Any] | None
) -> dict[str, Any] | None:
    """Return what the mask files hold, by file, and the curvatures they give; None without."""
    if not checks:
        return None
    worst = max(check.aperture_ratio_error_max for check in checks.values())
    files = {
        name: {
            "aperture_ratio_error_max": float(check.aperture_ratio_error_max),
            "aperture_ratio_min": float(check.aperture_ratio.min()),
            "aperture_ratio_max": float(check.aperture_ratio.max()),
            "ratio_map_error_max": float(check.ratio_map_error_max),
            "aperture_count": check.aperture_count,
            "smallest_aperture_um": _in_um(check.smallest_aperture),
            "smallest_web_um": _in_um(check.smallest_web),
            "width_mm": float(check.width),
            "length_mm": float(check.length),
            "database_unit_um": float(check.unit),
            "snap_error_um": _in_um(check.snap_error),
            "text": list(check.text),
            "window_count": None if check.windows is None else len(check.windows.windows),
            "window_violations": _violations(check),
        }
        for name, check in checks.items()
    }
    return {"aperture_ratio_error_max": float(worst), "files": files, "curvature": curvature}


def _violations(check: MaskCheck) -> int | None:
    return None if check.windows is None else len(check.windows.violations)


def describe_step(check: StepCheck | None) -> dict[str, Any] | None:
    """Return what film.step holds; None where it does not read back."""
    if check is None:
        return None
    return {
        "valid": bool(check.valid),
        "unit": check.unit,
        "bodies_volume_mm3": {name: float(volume) for name, volume in check.bodies.items()},
        "volume_error": float(check.volume_error),
    }


def describe_mesh(check: MeshCheck | None) -> dict[str, Any] | None:
    """Return what film.stl holds; None where it is no closed mesh."""
    if check is None:
        return None
    return {
        "watertight": bool(check.watertight),
        "triangle_count": int(check.triangle_count),
        "volume_error": float(check.volume_error),
        "normal_error_deg_rms": float(check.normal_error_rms / deg),
        "secant_error_deg_rms": _in_deg(check.secant_error_rms),
        "secant_error_deg_rms_worst_groove": _in_deg(check.secant_error_groove),
        "secant_error_deg_max": _in_deg(check.secant_error_max),
        "tip_error_um_max": float(check.tip_error_max / um),
        "normal_error_deg_max": float(check.normal_error_max / deg),
    }


def describe_library(check: LibraryCheck) -> dict[str, Any]:
    """Return what a film of instances holds."""
    return {
        "pieces": len(check.volume),
        "places": list(check.curvature.shape[:2]),
        "triangle_count": sum(check.triangle_count.values()),
        "curvature_min_per_mm": float(check.curvature.min()),
        "curvature_max_per_mm": float(check.curvature.max()),
        "volume_mm3": check.solid,
    }


def describe_agreement(agreement: Agreement | None) -> dict[str, Any] | None:
    """Return how far film.stl is from film.step; None unless both read back."""
    if agreement is None:
        return None
    return {
        "distance_um_max": float(agreement.distance_max / um),
        "volume_difference": float(agreement.volume_difference),
    }


def describe_resin(resin: ResinCheck | None) -> dict[str, Any] | None:
    """Return the resin of the piece in outside names; None without a mask."""
    if resin is None:
        return None
    return {
        "by_mask_mm3": {name: float(volume) for name, volume in resin.by_mask.items()},
        "in_mesh_mm3": float(resin.in_mesh),
        "full_grooves_mm3": float(resin.full),
        "difference": float(resin.difference),
    }


def _in_deg(angle: float | None) -> float | None:
    return None if angle is None else float(angle) / deg


def _in_um(length: float | None) -> float | None:
    return None if length is None else float(length) / um
