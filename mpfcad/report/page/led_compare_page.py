"""The page of `mpfcad compare` under LEDs: a table, and every film from above on one scale."""

from typing import Any

from mpfcad.report.film.decision import strip_values
from mpfcad.report.page.environment import render
from mpfcad.report.page.number import number, with_interval

Record = dict[str, Any]
_HEAD = (
    "film", "lamp-Mura contrast", "9 points", "× eye's threshold", "SEMU", "luminance", "light out",
    "sheets",
)  # fmt: skip


def build_led_compare_page(record: Record) -> str:
    """Return the page; the same record gives the same bytes."""
    cases = record["cases"]
    stacks = {case["traced"]["stack"] for case in cases}
    names = [_name(case, len(stacks) > 1) for case in cases]
    return render(
        "compare_led.html.j2",
        name="Comparison",
        kind="films under LEDs",
        head=f"{len(cases)} cases in {', '.join(sorted(stacks))}; seed {record['seed']}, effort "
        f"{record['effort']}.",
        table_head=_HEAD,
        rows=[_row(*pair) for pair in zip(names, cases, strict=True)],
        strips=strip_values(
            [(name, case["contrast"]) for name, case in zip(names, cases, strict=True)]
        ),
    )


def _name(case: Record, is_told: bool) -> str:
    """Return a case's name, with its stack where these differ."""
    label = str(case["label"])
    return label if is_told else label.removesuffix(f" in {case['traced']['stack']}")


def _about(found: Record, digits: int) -> str:
    return f"{found['value']:.{digits}f} ± {found['standard_error']:.{digits}f}"


def _row(name: str, case: Record) -> list[str]:
    found = case["contrast"]
    seen = found["visibility"]
    return [
        name,
        with_interval(found["lamp_mura_contrast"], 4),
        _about(found["points"]["9"]["min_over_max"], 3),
        "none" if seen is None else _about(seen["over_threshold"], 1),
        _about(found["semu"]["value"], 2),
        _about(case["relative_luminance"], 3),
        number(found["energy"]["out"], 3),
        str(case["sheet_count"]),
    ]
