"""What a page shows of the luminance over a cell of LEDs: evenness, harmonics, visibility."""

from typing import Any

from mpfcad.report.page.number import with_interval

Record = dict[str, Any]
#: Pairs of harmonics that are listed, the largest first.
_LISTED = 4


def cell_rows(record: Record) -> list[tuple[str, str]]:
    """Return the figures of a cell with their 95 % intervals."""
    rows = [("σ / mean", with_interval(record["sigma_over_mean"], 4))]
    for count, points in record["points"].items():
        rows += [
            (f"L_{{min}}/L_{{max}} on {count} points", with_interval(points["min_over_max"], 3)),
            (f"L_{{max}}/L_{{min}} on {count} points", with_interval(points["max_over_min"], 3)),
        ]
    largest = sorted(record["harmonic_amplitude"].items(), key=lambda pair: -pair[1]["value"])
    for name, amplitude in largest[:_LISTED]:
        words = name.replace("_", " ")
        rows.append((f"harmonic {words}, over the mean", with_interval(amplitude, 4)))
    rows.append(("above an LED [cd/m²]", with_interval(record["luminance_above_led_cd_m2"], 0)))
    seen, spot = record.get("visibility"), record.get("semu")
    if seen:
        rows += [
            (f"visibility at {seen['viewing_distance_mm'] / 1000:g} m: worst harmonic "
             f"({seen['harmonic'].replace('_', ' ')}, {seen['wavelength_mm']:.3g} mm) over the "
             f"eye's threshold {seen['threshold_contrast']:.4f}",
             with_interval(seen["over_threshold"], 2)),
        ]  # fmt: skip
    if spot:
        rows.append(
            (f"SEMU of what is {spot['part']} the mean, {spot['area_mm2']:.3g} mm² a cell",
             with_interval(spot["value"], 2))
        )  # fmt: skip
    return rows


def way_words(record: Record) -> str:
    """Return which way a cell was traced, a sentence."""
    way = record["estimator"]
    start = {"forward": "from the LEDs", "backward": "from the meter"}[way["name"]]
    more = way["paths_to_goal"]
    goal = f" The goal of the contrast takes about {more / 1e6:.3g} million." if more else ""
    return f"Paths {start}: {way['reason']}.{goal}"
