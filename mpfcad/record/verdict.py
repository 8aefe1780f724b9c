"""The gates of a verdict in their order; what a gate is stands in `mpfcad.gate`."""

from collections.abc import Iterable

from mpfcad.gate import Gate, worst_of_each

#: Every gate that a verdict may have, in the order of report and command line.
ORDER = (
    "lamp_mura_contrast",
    "confidence",
    "colour_mura",
    "mask_file_as_written",
    "mask_aperture_ratio_error",
    "mask_rule_violations",
    "screen_release",
    "screen_ratio_min",
    "screen_ratio_max",
    "screen_aperture_um",
    "screen_web_um",
    "screen_ripple_per_mm",
    "screen_ripple_luminance",
    "screen_registration_per_mm",
    "step_valid",
    "step_volume_error",
    "step_extent_error_um",
    "step_curvature_error",
    "step_place_error_um",
    "mesh_watertight",
    "mesh_volume_error",
    "mesh_extent_error_um",
    "mesh_normal_error_deg",
    "mesh_normal_error_deg_rms",
    "mesh_height_error_um",
    "mesh_curvature_error_per_mm",
    "library_as_written",
    "step_mesh_distance_um",
    "step_mesh_volume_difference",
    "mask_mesh_curvature_difference_per_mm",
    "resin_volume_difference",
    "traced_file_is_shipped_file",
    "energy_imbalance_sigma",
    "energy_lost",
)


def in_order(gates: Iterable[Gate]) -> list[Gate]:
    """Return one gate of each name, the worst, in the order of `ORDER`.

    Raises
    ------
    ValueError
        for a gate that `ORDER` does not have, and so the report no words for.
    """
    return sorted(worst_of_each(gates), key=lambda gate: ORDER.index(gate.name))
