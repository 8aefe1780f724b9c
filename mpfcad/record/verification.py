"""verification.json: everything that was found, in outside names and plain values.

docs/verification.md says what each key means. The document holds no time, no absolute path and
nothing that depends on the number of threads, so the same job gives the same bytes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.gate import Gate, worst_outcome, yes_no
from mpfcad.mask import MaskCheck
from mpfcad.mask.screen.printing import Printing
from mpfcad.measure import Estimate, LuminanceResult, Survey
from mpfcad.measure.rounds import LOST_LIMIT
from mpfcad.record.file import (
    ResinCheck,
    describe_agreement,
    describe_masks,
    describe_mesh,
    describe_resin,
    describe_step,
)
from mpfcad.record.printing import PrintLimits, mask_gates, print_gates, printability
from mpfcad.record.survey import describe_survey
from mpfcad.record.verdict import in_order

SCHEMA = 1
CONTRAST_FORMULA = "(Lmax - Lmin) / (Lmax + Lmin)"
#: Limits of what is found from several files, and of the trace. Those of one file stand where it is
#: checked, the contrast's are the job's.
CURVATURE_LIMIT = 0.1
RESIN_LIMIT = 0.001
BALANCE_LIMIT = 5.0


@dataclass(frozen=True)
class Checks:
    """What the files of an export turned out to be, before any tracing.

    Attributes
    ----------
    mask
        check of each mask file by its name; without those that do not read back as masks
    step, mesh
        checks of film.step and film.stl; None where the file does not read back as one
    agreement
        film.step against film.stl; None unless both do
    gates
        of the files, each as often as there are files
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
    step: StepCheck | None
    mesh: MeshCheck | None
    agreement: Agreement | None
    gates: Sequence[Gate]
    curvature_difference: float | None
    resin: ResinCheck | None
    is_traced_file: bool
    printing: Printing | None = None


def build_gates(
    checks: Checks,
    luminance: LuminanceResult | None,
    *,
    contrast_pass: float,
    contrast_marginal: float,
    print_limits: PrintLimits,
) -> list[Gate]:
    """Return the gates in the order of the report; contrasts as fractions.

    Without a mesh that can be traced there is no `luminance`, and the contrast is not decided.
    """
    difference, resin = checks.curvature_difference, checks.resin
    gates = [contrast_gate(luminance, contrast_pass, contrast_marginal), *checks.gates]
    gates += mask_gates(checks.mask)
    gates += print_gates(checks.printing, checks.mask, print_limits)
    if difference is not None:
        name = "mask_mesh_curvature_difference_per_mm"
        gates.append(Gate(name, difference, CURVATURE_LIMIT, detail="film.stl"))
    if resin is not None:
        name = "resin_volume_difference"
        gates.append(Gate(name, resin.difference, RESIN_LIMIT, detail="film.stl"))
    if luminance is not None:
        gates.append(yes_no("traced_file_is_shipped_file", checks.is_traced_file, "film.stl"))
        gates += energy_gates(luminance.energy)
    return in_order(gates)


def contrast_gate(luminance: LuminanceResult | None, limit: float, marginal: float) -> Gate:
    """Return the gate of the lamp-Mura contrast."""
    if luminance is None:
        return Gate(
            "lamp_mura_contrast", None, limit, None, marginal, detail="film.stl: not traced"
        )
    found = luminance.contrast
    return Gate("lamp_mura_contrast", found.value, limit, (found.low, found.high), marginal)


def energy_gates(energy: dict[str, Any]) -> list[Gate]:
    """Return the gates of a trace's energy."""
    lost = energy["lost"] / energy["in"]
    return [
        Gate("energy_imbalance_sigma", _imbalance(energy), BALANCE_LIMIT),
        Gate("energy_lost", float(lost), LOST_LIMIT),
    ]


def confidence_gate(confidence: dict[str, Any], least: float) -> Gate:
    """Return the gate of the probability that the contrast is accepted in the real backlight."""
    found = confidence["probability"]["marginal"]
    low, high = found["ci95"]
    return Gate("confidence", found["value"], least, (low, high), at_least=True)


def build_verification(
    *,
    name: str,
    gates: list[Gate],
    checks: Checks,
    luminance: LuminanceResult | None,
    plain: LuminanceResult,
    baseline: LuminanceResult,
    baseline_stack: str,
    baseline_is_own: bool,
    eye: dict[str, Any] | None,
    confidence: dict[str, Any] | None = None,
    printed: dict[str, Any] | None = None,
    survey: Survey | None = None,
    facets: list[dict[str, Any]] | None = None,
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
        "directions": None if survey is None else describe_survey(survey),
        "facets": facets,
        "eye": eye,
        "plain": describe_luminance(plain),
        "baseline": {
            "stack": baseline_stack,
            "film": "BEF",
            "is_own": baseline_is_own,
            "words": f"a plain BEF in {'this backlight' if baseline_is_own else baseline_stack}",
            **describe_luminance(baseline),
        },
        "relative_luminance": _relative(luminance, baseline),
        "mask": describe_masks(checks.mask, curvature),
        "step": describe_step(checks.step),
        "mesh": describe_mesh(checks.mesh),
        "step_mesh": describe_agreement(checks.agreement),
        "mask_mesh_curvature_difference_per_mm": checks.curvature_difference,
        "resin": describe_resin(checks.resin),
        "process": process,
        "printing": None if checks.printing is None else checks.printing.document(),
        **({} if confidence is None else {"confidence": confidence}),
        **({} if printed is None else {"printed": printed}),
        "inputs": inputs,
        "provenance": provenance,
        "job": job,
    }


def _relative(luminance: LuminanceResult | None, baseline: LuminanceResult) -> float | None:
    if luminance is None:
        return None
    return luminance.mean_luminance.value / baseline.mean_luminance.value


#: The figures of a trace; each is null where there was nothing to trace.
TRACE_KEYS = (
    "luminance",
    "degrees_of_freedom",
    "fit",
    "lamp_mura_contrast",
    "mean_luminance_cd_m2",
    "energy",
    "paths",
    "convergence",
    "accelerator",
)


def describe_luminance(result: LuminanceResult | None) -> dict[str, Any]:
    """Return the figures of a trace in outside names."""
    if result is None:
        return dict.fromkeys(TRACE_KEYS)
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
        "convergence": {
            "paths": [int(row[0]) for row in result.convergence],
            "contrast": _numbers(result.convergence[:, 1]),
            "ci95": [_numbers(row[2:]) for row in result.convergence],
        },
        "accelerator": result.accelerator,
    }


def _imbalance(energy: dict[str, Any]) -> float:
    """Return |in - out - absorbed - lost| in standard errors."""
    return float(abs(energy["imbalance"]) / max(energy["imbalance_standard_error"], 1e-12))


def _estimate(estimate: Estimate) -> dict[str, Any]:
    return {"value": float(estimate.value), "ci95": [float(estimate.low), float(estimate.high)]}


def _numbers(values: Any) -> list[float]:
    return [float(value) for value in values]


def _plain(value: Any) -> Any:
    """Return nested tables of numpy scalars as plain numbers."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return value if isinstance(value, int | str) else float(value)
