"""The page of `mpfcad compare` under LEDs: a table, and every film from above on one scale."""

from typing import Any

from mpfcad.report.film.decision import strip_values
from mpfcad.report.page.environment import render
from mpfcad.report.page.number import number, with_interval

Record = dict[str, Any]
_HEAD = (
    "film and stack", "lamp-Mura contrast", "9 points, least / most", "harmonic / eye's threshold",
    "SEMU", "normal luminance / bare prisms", "light that leaves", "sheets",
)  # fmt: skip


def build_led_compare_page(record: Record) -> str:
    """Return the page; the same record gives the same bytes."""
    cases = record["cases"]
    return render(
        "compare_led.html.j2",
        name="Comparison",
        kind="films under LEDs",
        head=f"{len(cases)} cases, seed {record['seed']}, effort {record['effort']}.",
        table_head=_HEAD,
        rows=[_row(case) for case in cases],
        strips=strip_values([(case["label"], case["contrast"]) for case in cases]),
    )


def _row(case: Record) -> list[str]:
    found = case["contrast"]
    seen = found["visibility"]
    return [
        case["label"],
        with_interval(found["lamp_mura_contrast"], 4),
        with_interval(found["points"]["9"]["min_over_max"], 3),
        "none" if seen is None else with_interval(seen["over_threshold"], 1),
        with_interval(found["semu"]["value"], 2),
        with_interval(case["relative_luminance"], 3),
        number(found["energy"]["out"], 3),
        str(case["sheet_count"]),
    ]
