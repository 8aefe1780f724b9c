"""What the screen maker and the printer have to know of a mask, before it is made."""

from typing import Any

import numpy as np

from mpfcad.film import Process
from mpfcad.mask.aperture import Mask
from mpfcad.mask.fabric import Mesh
from mpfcad.mask.rule import ratio_range
from mpfcad.mask.screen.moire import Beat, MoireSetting, find_beats, gratings, suggest
from mpfcad.mask.screen.printing import Printing
from mpfcad.units import deg, um

#: Beats that are listed.
MOST_BEATS = 12


def describe_screen(
    mask: Mask, process: Process, setting: MoireSetting, printing: Printing
) -> dict[str, Any]:
    """Return the screen of a mask in outside names, fit for JSON."""
    wanted, groove = mask.wanted_ratio, process.groove
    low, high = ratio_range(mask.rules, groove.pitch, mask.period)
    high = min(high, process.aperture_ratio_max)
    return {
        "screen": "phototool only" if mask.rules.mesh is None else mask.rules.mesh.name,
        "pattern": mask.rules.pattern,
        "period_um": mask.period / um,
        "aperture_count": mask.aperture_count,
        "aperture_ratio": {
            "min": float(wanted.min()),
            "mean": float(wanted.mean()),
            "max": float(wanted.max()),
            "error_max": float(np.abs(mask.aperture_ratio - wanted).max()),
        },
        "makeable": {
            "aperture_ratio": [low, high],
            "curvature_per_mm": [float(process.curvature(high)), float(process.curvature(low))],
            "min_aperture_um": mask.rules.aperture_limit / um,
            "min_web_um": mask.rules.web_limit / um,
        },
        "full_groove_volume_cm3_m2": groove.area / groove.pitch / um,
        "mesh": _describe_mesh(mask.rules.mesh, process, setting, printing),
        "printing": printing.document(),
        "process": process.describe() if process.kind != "table" else {"kind": "table"},
        "moire": _describe_moire(mask, setting, float(wanted.mean())),
    }


def _describe_mesh(
    mesh: Mesh | None, process: Process, setting: MoireSetting, printing: Printing
) -> dict[str, Any] | None:
    if mesh is None:
        return None
    described: dict[str, Any] = {
        "name": mesh.name,
        "threads_per_cm": mesh.count * 10,
        "thread_um": mesh.thread / um,
        "opening_um": mesh.opening / um,
        "open_area": mesh.open_area,
        "thickness_um": mesh.thickness / um,
        "emulsion_um": mesh.emulsion / um,
        "angle_deg": setting.mesh_angle / deg,
        "ink_volume_cm3_m2": mesh.fabric_volume / um,
        "volume_with_emulsion_cm3_m2": mesh.volume / um,
        "volume_width": mesh.volume_width,
        "material": mesh.material,
        "transfer_factor_if_all_leaves": mesh.transfer_factor(process.groove),
        "source": mesh.source,
    }
    if process.transfer_factor is not None:
        described["transfer_factor"] = process.transfer_factor
        described["release"] = printing.release
    return described


def _describe_moire(mask: Mask, setting: MoireSetting, ratio: float) -> dict[str, Any]:
    rules, pitch = mask.rules, mask.pitch
    found = gratings(rules, setting, pitch, ratio)
    beats = find_beats(found, setting, rules.levelling_length)
    described: dict[str, Any] = {
        "viewing_distance_mm": setting.viewing_distance,
        "gratings": [grating.name for grating in found],
        "visible": sum(beat.is_visible for beat in beats),
        "beats": [_describe_beat(beat) for beat in beats[:MOST_BEATS]],
        "suggestion": None,
    }
    if any(beat.is_visible and {"pattern", "mesh"} & set(beat.pair) for beat in beats):
        better, turned, worst = suggest(rules, setting, pitch, ratio)
        described["suggestion"] = {
            "mesh_angle_deg": turned.mesh_angle / deg if rules.mesh else None,
            "pattern_angle_deg": better.angle / deg if rules.pattern == "angled" else None,
            "period_um": better.period / um,
            "worst_contrast": worst,
        }
    return described


def _describe_beat(beat: Beat) -> dict[str, Any]:
    return {
        "pair": list(beat.pair),
        "order": [list(order) for order in beat.order],
        "period_mm": beat.period,
        "direction_deg": beat.direction / deg,
        "contrast": beat.contrast,
        "visible": beat.is_visible,
    }


def screen_lines(screen: dict[str, Any]) -> list[str]:
    """Return a described screen as lines of text."""
    ratio, makeable = screen["aperture_ratio"], screen["makeable"]
    lines = [
        f"pattern {screen['pattern']}, period {screen['period_um']:.4g} µm, "
        f"{screen['aperture_count']} apertures",
        f"aperture ratio {ratio['min']:.4g} … {ratio['max']:.4g}, mean {ratio['mean']:.4g}; "
        f"a groove's mean is off by up to {ratio['error_max']:.2g}",
        "makeable: ratio {:.4g} … {:.4g}, curvature {:.4g} … {:.4g} /mm ".format(
            *makeable["aperture_ratio"], *makeable["curvature_per_mm"]
        )
        + f"(aperture from {makeable['min_aperture_um']:.4g} µm, "
        f"web from {makeable['min_web_um']:.4g} µm)",
        "after levelling over {levelling_length_mm:.3g} mm the curvature ripples by "
        "{ripple_curvature_per_mm:.2g} /mm rms in groove {ripple_groove}, the luminance by "
        "{ripple_luminance:.2g}".format(**screen["printing"]),
        "a print shifted by {registration_um:g} µm changes the curvature by up to "
        "{registration_curvature_per_mm:.2g} /mm".format(**screen["printing"]),
    ]
    width = screen["printing"]["curvature_half_width_per_mm"]
    lines.append(
        "how sure the process is: not known"
        if width is None
        else f"the process knows the curvature to ± {width:.2g} /mm (95 %)"
    )
    if screen["mesh"]:
        lines += _mesh_lines(screen["mesh"], screen["full_groove_volume_cm3_m2"])
    else:
        lines.append("phototool only: the job names no mesh, so nothing is said of printability")
    return lines + _moire_lines(screen["moire"])


def _mesh_lines(mesh: dict[str, Any], full: float) -> list[str]:
    lines = [
        "mesh {name}: opening {opening_um:.4g} µm, open area {open_area:.0%}, volume "
        "{volume_with_emulsion_cm3_m2:.4g} cm³/m² ({source})".format(**mesh),
        f"a full groove needs {full:.4g} cm³/m²: transfer factor "
        f"{mesh['transfer_factor_if_all_leaves']:.4g} if all leaves the screen",
    ]
    if "release" in mesh:
        lines[1] += (
            f"; the process has {mesh['transfer_factor']:.4g}, so {mesh['release']:.0%} leaves"
        )
    return lines


def _moire_lines(moire: dict[str, Any]) -> list[str]:
    lines = [
        f"moiré of {' × '.join(moire['gratings'])}: {moire['visible']} visible from "
        f"{moire['viewing_distance_mm']:g} mm"
    ]
    for beat in moire["beats"]:
        if beat["visible"]:
            lines.append(
                "  {0} × {1}: every {period_mm:.3g} mm at {direction_deg:.0f}°, contrast "
                "{contrast:.2g}".format(*beat["pair"], **beat)
            )
    better = moire["suggestion"]
    if better:
        parts = [
            f"{what} {better[key]:.4g} {unit}"
            for what, key, unit in (
                ("mesh at", "mesh_angle_deg", "°"),
                ("pattern at", "pattern_angle_deg", "°"),
                ("period", "period_um", "µm"),
            )
            if better[key] is not None
        ]
        lines.append(f"  better: {', '.join(parts)}: contrast {better['worst_contrast']:.2g}")
    return lines
