"""verification.json: everything that was found, in outside names and plain values.

docs/verification.md says what each key means. The document holds no time, no absolute path and
nothing that depends on the number of threads, so the same job gives the same bytes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.mask import MaskCheck
from mpfcad.mask.screen.printing import Printing
from mpfcad.measure import Estimate, LuminanceResult
from mpfcad.record.printing import PrintLimits, mask_gates, print_gates, printability
from mpfcad.record.verdict import Gate, worst_outcome
from mpfcad.units import deg, um

SCHEMA = 1
CONTRAST_FORMULA = "(Lmax - Lmin) / (Lmax + Lmin)"
#: Limits of the files and of the trace; the contrast's are the job's.
STEP_VOLUME_LIMIT = 1e-9
CURVATURE_LIMIT = 0.1
RESIN_LIMIT = 0.001
LOST_LIMIT = 1e-6
BALANCE_LIMIT = 5.0


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


@dataclass(frozen=True)
class Checks:
    """What the files of an export turned out to be, before any tracing.

    Attributes
    ----------
    mask
        check of each mask file by its name; empty without a mask
    step, mesh
        checks of film.step and film.stl
    agreement
        film.step against film.stl
    curvature_difference
        largest |C of the mask - C of the facets| [1/mm]; None of a measured surface
    resin
        resin by the masks and in the mesh; None without a mask
    is_traced_file
        whether the mesh that was traced is byte for byte the file in the export
    printing
        what the screen prints; None without a mask
    """

    mask: Mapping[str, MaskCheck]
    step: StepCheck
    mesh: MeshCheck
    agreement: Agreement
    curvature_difference: float | None
    resin: ResinCheck | None
    is_traced_file: bool
    printing: Printing | None = None


def build_gates(
    checks: Checks,
    luminance: LuminanceResult,
    *,
    contrast_pass: float,
    contrast_marginal: float,
    print_limits: PrintLimits,
) -> list[Gate]:
    """Return the gates in the order of the report; contrasts as fractions."""
    contrast = luminance.contrast
    step, mesh, agreement = checks.step, checks.mesh, checks.agreement
    lost = luminance.energy["lost"] / luminance.energy["in"]
    gates = [
        Gate(
            "lamp_mura_contrast",
            contrast.value,
            contrast_pass,
            (contrast.low, contrast.high),
            contrast_marginal,
        )
    ]
    return [
        *gates,
        *mask_gates(checks.mask),
        *print_gates(checks.printing, checks.mask, print_limits),
        Gate("step_valid", float(step.valid), 1.0, at_least=True),
        Gate("step_volume_error", step.volume_error, STEP_VOLUME_LIMIT),
        Gate("mesh_watertight", float(mesh.watertight), 1.0, at_least=True),
        Gate("mesh_volume_error", abs(mesh.volume_error), mesh.volume_limit),
        Gate("mesh_normal_error_deg", mesh.normal_error_max / deg, mesh.normal_error_limit / deg),
        Gate("step_mesh_distance_um", agreement.distance_max / um, agreement.distance_limit / um),
        Gate("step_mesh_volume_difference", agreement.volume_difference, agreement.volume_limit),
        *_curvature_gate(checks.curvature_difference),
        *_resin_gate(checks.resin),
        Gate("traced_file_is_shipped_file", float(checks.is_traced_file), 1.0, at_least=True),
        Gate("energy_imbalance_sigma", _imbalance(luminance.energy), BALANCE_LIMIT),
        Gate("energy_lost", lost, LOST_LIMIT),
    ]


def _curvature_gate(difference: float | None) -> list[Gate]:
    if difference is None:
        return []
    return [Gate("mask_mesh_curvature_difference_per_mm", difference, CURVATURE_LIMIT)]


def _resin_gate(resin: ResinCheck | None) -> list[Gate]:
    if resin is None:
        return []
    return [Gate("resin_volume_difference", resin.difference, RESIN_LIMIT)]


def build_verification(
    *,
    name: str,
    gates: list[Gate],
    checks: Checks,
    luminance: LuminanceResult,
    plain: LuminanceResult,
    baseline: LuminanceResult,
    baseline_stack: str,
    eye: dict[str, Any],
    inputs: list[dict[str, Any]],
    process: dict[str, Any] | None,
    curvature: dict[str, Any] | None,
    provenance: dict[str, Any],
    job: dict[str, Any],
) -> dict[str, Any]:
    """Return the whole document, every number finite and plain."""
    return {
        "schema": SCHEMA,
        "name": name,
        "verdict": worst_outcome(gates),
        "printability": printability(checks.printing, gates),
        "gates": [gate.document() for gate in gates],
        **describe_luminance(luminance),
        "eye": eye,
        "plain": describe_luminance(plain),
        "baseline": {"stack": baseline_stack, "film": "BEF", **describe_luminance(baseline)},
        "relative_luminance": luminance.mean_luminance.value / baseline.mean_luminance.value,
        "mask": describe_masks(checks.mask, curvature),
        "step": describe_step(checks.step),
        "mesh": describe_mesh(checks.mesh),
        "step_mesh": describe_agreement(checks.agreement),
        "mask_mesh_curvature_difference_per_mm": checks.curvature_difference,
        "resin": describe_resin(checks.resin),
        "process": process,
        "printing": None if checks.printing is None else checks.printing.document(),
        "inputs": inputs,
        "provenance": provenance,
        "job": job,
    }


def describe_luminance(result: LuminanceResult) -> dict[str, Any]:
    """Return the figures of a trace in outside names."""
    return {
        "luminance": {
            "position_pitch": _numbers(result.position_pitch),
            "luminance_cd_m2": _numbers(result.luminance),
            "standard_error_cd_m2": _numbers(result.standard_error),
        },
        "degrees_of_freedom": float(result.freedom),
        "fit": {
            "coefficient_cd_m2": _numbers(result.fit.coefficient),
            "chi2_excess": float(result.fit.chi2_excess),
        },
        "curve": {
            "luminance_cd_m2": _numbers(result.central_curve),
            "values": result.curve.values,
            "misfit": result.curve.misfit,
            "smoothed": not result.curve.is_sharp,
        },
        "meter": result.spot.describe(),
        "pitches": [_estimate(one) for one in result.pitches],
        "lamp_mura_contrast": {**_estimate(result.contrast), "formula": CONTRAST_FORMULA},
        "mean_luminance_cd_m2": _estimate(result.mean_luminance),
        "energy": _plain(result.energy),
        "paths": int(result.paths),
        "accelerator": result.accelerator,
    }


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


def describe_step(check: StepCheck) -> dict[str, Any]:
    """Return what film.step holds."""
    return {
        "valid": bool(check.valid),
        "unit": check.unit,
        "bodies_volume_mm3": {name: float(volume) for name, volume in check.bodies.items()},
        "volume_error": float(check.volume_error),
    }


def describe_mesh(check: MeshCheck) -> dict[str, Any]:
    """Return what film.stl holds."""
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


def describe_agreement(agreement: Agreement) -> dict[str, Any]:
    """Return how far film.stl is from film.step."""
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


def find_difference(stored: Any, found: Any, where: str = "") -> str | None:
    """Return the first place where two documents differ, as `key.key: stored, found`, or None."""
    if isinstance(stored, dict) and isinstance(found, dict):
        for key in [*stored, *(key for key in found if key not in stored)]:
            place = f"{where}.{key}" if where else key
            if key not in stored or key not in found:
                return f"{place}: only in the {'file' if key in stored else 'new result'}"
            difference = find_difference(stored[key], found[key], place)
            if difference:
                return difference
        return None
    if isinstance(stored, list) and isinstance(found, list) and len(stored) == len(found):
        pairs = enumerate(zip(stored, found, strict=True))
        hits = (find_difference(a, b, f"{where}[{i}]") for i, (a, b) in pairs)
        return next((hit for hit in hits if hit), None)
    return None if stored == found else f"{where}: stored {stored!r}, found {found!r}"


def _imbalance(energy: dict[str, Any]) -> float:
    """Return |in - out - absorbed - lost| in standard errors."""
    return float(abs(energy["imbalance"]) / max(energy["imbalance_standard_error"], 1e-12))


def _estimate(estimate: Estimate) -> dict[str, Any]:
    return {"value": float(estimate.value), "ci95": [float(estimate.low), float(estimate.high)]}


def _numbers(values: Any) -> list[float]:
    return [float(value) for value in values]


def _in_deg(angle: float | None) -> float | None:
    return None if angle is None else float(angle) / deg


def _in_um(length: float | None) -> float | None:
    return None if length is None else float(length) / um


def _plain(value: Any) -> Any:
    """Return nested tables of numpy scalars as plain numbers."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return value if isinstance(value, int | str) else float(value)
