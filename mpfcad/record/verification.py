"""verification.json: everything that was found, in outside names and plain values.

docs/verification.md says what each key means. The document holds no time, no absolute path and
nothing that depends on the number of threads, so the same job gives the same bytes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.cad.check.library import LibraryCheck
from mpfcad.gate import Gate, worst_outcome, yes_no
from mpfcad.mask import MaskCheck
from mpfcad.mask.screen.printing import Printing
from mpfcad.measure import CellResult, LuminanceResult, Survey
from mpfcad.measure.rounds import LOST_LIMIT
from mpfcad.record.cell import describe_cell
from mpfcad.record.file import (
    ResinCheck,
    describe_agreement,
    describe_library,
    describe_masks,
    describe_mesh,
    describe_resin,
    describe_step,
)
from mpfcad.record.luminance import TRACE_KEYS, describe_luminance
from mpfcad.record.printing import PrintLimits, mask_gates, print_gates, printability
from mpfcad.record.survey import describe_survey
from mpfcad.record.verdict import in_order

SCHEMA = 1
#: A luminance over what repeats.
Traced = LuminanceResult | CellResult
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
    library
        check of film.3mf, a film of instances
    traced
        name of the file that was traced
    crossed
        of the printed film that lies across, if there is one
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
    library: LibraryCheck | None = None
    traced: str = "film.stl"
    crossed: "Checks | None" = None

    @property
    def films(self) -> "tuple[Checks, ...]":
        """The checks of each film, this one first."""
        return (self,) if self.crossed is None else (self, self.crossed)

    @property
    def masks(self) -> dict[str, MaskCheck]:
        """The checks of the mask files of all films."""
        return {name: check for film in self.films for name, check in film.mask.items()}


def build_gates(
    checks: Checks,
    luminance: Traced | None,
    *,
    contrast_pass: float,
    contrast_marginal: float,
    print_limits: PrintLimits,
) -> list[Gate]:
    """Return the gates in the order of the report; contrasts as fractions.

    Without a mesh that can be traced there is no `luminance`, and the contrast is not decided.
    """
    gates = [contrast_gate(luminance, contrast_pass, contrast_marginal, checks.traced)]
    for film in checks.films:
        gates += _film_gates(film, luminance is not None, print_limits)
    if luminance is not None:
        gates += energy_gates(luminance.energy)
    return in_order(gates)


def _film_gates(checks: Checks, is_traced: bool, limits: PrintLimits) -> list[Gate]:
    """Return the gates of one film's files."""
    difference, resin = checks.curvature_difference, checks.resin
    gates = [*checks.gates, *mask_gates(checks.mask)]
    gates += print_gates(checks.printing, checks.mask, limits)
    if difference is not None:
        name = "mask_mesh_curvature_difference_per_mm"
        gates.append(Gate(name, difference, CURVATURE_LIMIT, detail=checks.traced))
    if resin is not None:
        name = "resin_volume_difference"
        gates.append(Gate(name, resin.difference, RESIN_LIMIT, detail=checks.traced))
    if is_traced:
        same = checks.is_traced_file
        gates.append(yes_no("traced_file_is_shipped_file", same, checks.traced))
    return gates


def contrast_gate(
    luminance: Traced | None, limit: float, marginal: float, traced: str = "film.stl"
) -> Gate:
    """Return the gate of the lamp-Mura contrast."""
    if luminance is None:
        return Gate(
            "lamp_mura_contrast", None, limit, None, marginal, detail=f"{traced}: not traced"
        )
    found = luminance.contrast
    interval = (found.low, found.high)
    where = luminance.where if isinstance(luminance, LuminanceResult) else ""
    detail = f"{traced}: {where}" if where else ""
    return Gate("lamp_mura_contrast", found.value, limit, interval, marginal, detail=detail)


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


def colour_gate(colour: dict[str, Any] | None, limit: float, traced: str) -> Gate:
    """Return the gate of the colour Mura; without a trace it is not decided."""
    if colour is None:
        return Gate("colour_mura", None, limit, detail=f"{traced}: not traced")
    found = colour["colour_mura"]
    low, high = found["ci95"]
    return Gate("colour_mura", found["value"], limit, (low, high))


def build_verification(
    *,
    name: str,
    gates: list[Gate],
    checks: Checks,
    seed: int,
    distance: float,
    luminance: Traced | None,
    plain: Traced,
    baseline: Traced,
    baseline_stack: str,
    baseline_is_own: bool,
    eye: dict[str, Any] | None,
    confidence: dict[str, Any] | None = None,
    printed: dict[str, Any] | None = None,
    survey: Survey | None = None,
    psf: dict[str, Any] | None = None,
    facets: list[dict[str, Any]] | None = None,
    colour: dict[str, Any] | None = None,
    halftone: Sequence[dict[str, Any]] = (),
    notes: Sequence[str] = (),
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
        **describe_traced(luminance, seed, distance),
        "directions": None if survey is None else describe_survey(survey),
        "facets": facets,
        "eye": eye,
        "plain": describe_traced(plain, seed, distance),
        "baseline": {
            "stack": baseline_stack,
            "film": "BEF",
            "is_own": baseline_is_own,
            "words": f"a plain BEF in {'this backlight' if baseline_is_own else baseline_stack}",
            **describe_traced(baseline, seed, distance),
        },
        "relative_luminance": _relative(luminance, baseline),
        "mask": describe_masks(checks.masks, curvature),
        "step": describe_step(checks.step),
        "mesh": describe_mesh(checks.mesh),
        "step_mesh": describe_agreement(checks.agreement),
        "mask_mesh_curvature_difference_per_mm": checks.curvature_difference,
        "resin": describe_resin(checks.resin),
        "process": process,
        "printing": None if checks.printing is None else checks.printing.document(),
        **({} if checks.library is None else {"library": describe_library(checks.library)}),
        **({} if checks.crossed is None else {"crossed": _describe_crossed(checks.crossed)}),
        **({} if psf is None else {"psf": psf}),
        **({} if confidence is None else {"confidence": confidence}),
        **({} if colour is None else {"colour": colour}),
        **({} if printed is None else {"printed": printed}),
        **({"halftone": list(halftone)} if halftone else {}),
        **({"notes": list(notes)} if notes else {}),
        "inputs": inputs,
        "provenance": provenance,
        "job": job,
    }


def _describe_crossed(checks: Checks) -> dict[str, Any]:
    """Return what the files of the film that lies across turned out to be."""
    return {
        "library": None if checks.library is None else describe_library(checks.library),
        "mask_mesh_curvature_difference_per_mm": checks.curvature_difference,
        "resin": describe_resin(checks.resin),
        "printing": None if checks.printing is None else checks.printing.document(),
    }


def _relative(luminance: Traced | None, baseline: Traced) -> float | None:
    if luminance is None:
        return None
    return luminance.mean_luminance.value / baseline.mean_luminance.value


def describe_traced(result: Traced | None, seed: int, distance: float) -> dict[str, Any]:
    """Return the figures of a trace over a lamp pitch, or over a cell of LEDs.

    Of a cell there is no curve: `luminance` is null and `cell` has the map.
    """
    if isinstance(result, CellResult):
        return {**dict.fromkeys(TRACE_KEYS), **describe_cell(result, seed, distance)}
    return describe_luminance(result)


def _imbalance(energy: dict[str, Any]) -> float:
    """Return |in - out - absorbed - lost| in standard errors."""
    return float(abs(energy["imbalance"]) / max(energy["imbalance_standard_error"], 1e-12))
