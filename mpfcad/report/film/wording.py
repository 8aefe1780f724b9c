"""The report's words: what each gate means, and the verdict as a sentence."""

from typing import Any

from mpfcad.report.page.number import number, with_interval

#: Gate -> (what it is, how it is computed: `_{…}` is lowered).
GATES = {
    "lamp_mura_contrast": (
        "Lamp-Mura contrast",
        "(L_{max} − L_{min}) / (L_{max} + L_{min}) over one lamp pitch, or one cell of LEDs",
    ),
    "confidence": (
        "Confidence in the real backlight",
        "probability that the contrast is accepted with all inputs' widths (docs/confidence.md)",
    ),
    "colour_mura": (
        "Colour Mura",
        "largest Δu′v′ (CIE 1976) of the normal light over a lamp pitch from its mean",
    ),
    "mask_file_as_written": (
        "Mask: files read back",
        "panel, apertures, text and furniture of each file, by another library than wrote it",
    ),
    "mask_aperture_ratio_error": (
        "Mask: aperture ratio",
        "max |read back from the file − wanted| over all grooves",
    ),
    "mask_rule_violations": (
        "Mask: apertures and webs",
        "places narrower than min_aperture_um or min_web_um in sampled windows, by klayout",
    ),
    "screen_release": (
        "Screen: release",
        "resin laid down over a full area / ink volume of the mesh",
    ),
    "screen_ratio_min": ("Screen: smallest aperture ratio", "of the open grooves, from the file"),
    "screen_ratio_max": ("Screen: largest aperture ratio", "of all grooves, from the file"),
    "screen_aperture_um": (
        "Screen: smallest aperture [µm]",
        "from the file; limit: one cell of the mesh, and min_aperture_um",
    ),
    "screen_web_um": (
        "Screen: smallest web [µm]",
        "from the file; limit: one cell of the mesh, and min_web_um",
    ),
    "screen_ripple_per_mm": (
        "Ripple after levelling [1/mm]",
        "root mean square of the curvature along the worst groove",
    ),
    "screen_ripple_luminance": (
        "Ripple after levelling: luminance",
        "that ripple × the luminance response (docs/process.md)",
    ),
    "screen_registration_per_mm": (
        "Registration [1/mm]",
        "largest change of a groove's curvature by a shift of registration_um",
    ),
    "step_valid": ("STEP: valid solids", "checked by OCCT after reading the file again"),
    "step_volume_error": ("STEP: volume", "max |V_{file} / V_{closed form} − 1|"),
    "step_extent_error_um": (
        "STEP: extent [µm]",
        "largest distance of the bounding box's corners from the film's",
    ),
    "step_curvature_error": ("STEP: parabolas", "max |C_{file} / C − 1| over all grooves"),
    "step_place_error_um": (
        "STEP: place of the parabolas [µm]",
        "largest distance of a vertex from its place",
    ),
    "mesh_watertight": ("STL: one closed mesh", "each edge belongs to exactly two facets"),
    "mesh_volume_error": ("STL: volume", "|V_{file} / V_{closed form} − 1|"),
    "mesh_normal_error_deg": (
        "STL: facet normals [°]",
        "angle to the true surface at the facet's ends, of the facet nearest to its limit",
    ),
    "mesh_extent_error_um": (
        "STL: extent [µm]",
        "largest distance of the bounding box's corners from the film's, both in float32",
    ),
    "mesh_normal_error_deg_rms": (
        "STL: facet normals, rms [°]",
        "angle to the true surface at the facets' middles; limit: or what float32 forces",
    ),
    "mesh_height_error_um": (
        "STL: heights [µm]",
        "largest distance in z of a corner from the true surface; limit: what float32 forces",
    ),
    "mesh_curvature_error_per_mm": (
        "STL: curvature [1/mm]",
        "max |C from the facets − C| over all grooves",
    ),
    "library_as_written": (
        "3MF: pieces and places",
        "each piece closed, on the surface and of its volume; at each place the piece wanted",
    ),
    "step_mesh_distance_um": (
        "STL against STEP [µm]",
        "largest distance of a corner of the STL from the STEP's surfaces; limit: float32 and 1 nm",
    ),
    "step_mesh_volume_difference": (
        "STL against STEP: volume",
        "|V_{STL} / V_{STEP} − 1|",
    ),
    "mask_mesh_curvature_difference_per_mm": (
        "Mask against STL [1/mm]",
        "max |C from the mask's aperture ratio − C from the STL's facets|",
    ),
    "resin_volume_difference": (
        "Mask against STL: resin",
        "|resin by the mask's aperture ratios − (V_{STL} − V_{bare prisms})| over "
        "that of full grooves",
    ),
    "traced_file_is_shipped_file": (
        "The traced file is the shipped file",
        "SHA-256 of the film's file when traced and in this export",
    ),
    "energy_imbalance_sigma": (
        "Energy balance [σ]",
        "|in − out − absorbed − lost| in standard errors, by a forward trace",
    ),
    "energy_lost": ("Lost light", "weight of paths that ended nowhere / weight of all paths"),
}
#: Gates whose value is yes or no.
YES_NO = (
    "mask_file_as_written",
    "step_valid",
    "mesh_watertight",
    "library_as_written",
    "traced_file_is_shipped_file",
)

_SENTENCES = {
    "PASS": "By the job's limits the {lamps} are invisible: the whole 95 % interval is within "
    "{limit}.",
    "MARGINAL": "By the job's limits the {lamps} are barely visible: the whole 95 % interval is "
    "within {marginal}, but not within {limit}.",
    "INCONCLUSIVE": "Not decided: the 95 % interval straddles the acceptance limit {marginal}. "
    "Trace longer: --effort standard or final.",
    "FAIL": "By the job's limits the {lamps} are visible: the whole 95 % interval is above the "
    "acceptance limit {marginal}.",
}


def sources_of(record: dict[str, Any]) -> str:
    """Return what the light sources of a run are called: lamps or LEDs."""
    return "LEDs" if record.get("cell") else "lamps"


def states_confidence(record: dict[str, Any]) -> bool:
    """Return whether `mpfcad run --confidence` takes this backlight and film.

    Tubes without a rim, and LEDs under films of grooves without halftones, in one wavelength.
    """
    job = record.get("job", {}).get("resolved", {})
    grooves = job.get("film", {}).get("cell", "groove") == "groove"
    is_held = not record.get("cell") or (grooves and not job.get("halftone"))
    return is_held and not record.get("judged") and "colour" not in record


def verdict_sentence(record: dict[str, Any]) -> str:
    """Return what the contrast's gate decides, as a sentence."""
    gate = record["gates"][0]
    if gate["value"] is None:
        file = gate.get("detail", "film.stl").partition(":")[0]
        what = "one closed mesh" if file == "film.stl" else "the film of instances"
        return f"Not traced: {file} does not read back as {what}."
    words = _SENTENCES[gate["outcome"]].format(
        limit=f"{gate['limit']:g}",
        marginal=f"{gate['marginal_limit']:g}",
        lamps=sources_of(record),
    )
    if record.get("printability") == "phototool only":
        words += (
            " Phototool only: the job names no mesh, so nothing is said of whether a screen "
            "prints it."
        )
    return words + print_sentence(record)


def print_sentence(record: dict[str, Any]) -> str:
    """Return what a print makes of it, beside the verdict; empty where that is in it, or no print.

    The contrast's own interval is the trace's noise.
    """
    if record.get("process") is None or "confidence" in record:
        return ""
    half = (record.get("printing") or {}).get("curvature_half_width_per_mm")
    known = "is not known" if half is None else f"is ± {half:.2g} /mm (95 %)"
    words = f" That is the film as designed. How well the process sets C {known}"
    printed = record.get("printed")
    if printed is None:
        return f"{words}: the verdict leaves it out. Print the step wedge and calibrate."
    low, high = printed["contrast"]["ci95"]
    found = printed["probability"]["marginal"]
    return (
        f"{words}: as printed the contrast lies between {low:.4f} and {high:.4f} (95 %) and is at "
        f"most {found['limit']:g} with a probability of {found['value']:.0%}."
    )


def label_of(name: str) -> str:
    """Return what a gate is; the name itself for one of another version."""
    return GATES[name][0] if name in GATES else name


def gate_values(gate: dict[str, Any]) -> dict[str, Any]:
    """Return what stands in a gate's line: what, how, value with interval, limits, outcome."""
    formula = GATES.get(gate["name"], ("", ""))[1]
    sign = "≥" if gate.get("at_least") else "≤"
    value: str = "not measured" if gate["value"] is None else number(gate["value"], 3)
    limit: str = sign + " " + number(gate["limit"], 3)
    if gate["name"] in YES_NO:
        value, limit = ("yes" if gate["value"] else "no"), "yes"
    if gate["ci95"] is not None:
        value = with_interval(gate, 4)
    marginal = sign + " " + number(gate["marginal_limit"], 3) if "marginal_limit" in gate else ""
    return {
        "label": label_of(gate["name"]),
        "formula": formula,
        "value": value,
        "limit": limit,
        "marginal": marginal,
        "outcome": gate["outcome"],
        "detail": gate.get("detail", ""),
    }
