"""The sliders of the inputs whose effect on the curve was traced: all, or the print alone."""

from typing import Any

from mpfcad.report.drawing.plot import plot
from mpfcad.report.drawing.response_figure import REACH, response_data, response_figure

Record = dict[str, Any]


def slider_values(record: Record) -> Record | None:
    """Return the plot, its data and a slider an input; None where no effect was traced."""
    inputs = effects(record)
    if not inputs or not record.get("luminance"):
        return None
    return {
        "plot": plot(response_figure(record), "response"),
        "data": response_data(record, inputs),
        "inputs": [_slider(number, one) for number, one in enumerate(inputs)],
    }


def effects(record: Record) -> list[Record]:
    """Return the inputs with an effect: those of the confidence, else those of the print."""
    found = record.get("confidence") or record.get("printed") or {"inputs": []}
    return [one for one in found["inputs"] if "effect_of_sigma" in one]


def _slider(number: int, one: Record) -> Record:
    """Return the slider of an input, in standard uncertainties, no farther than it can be."""
    ends = []
    for key, sign in (("low", -1), ("high", 1)):
        limit = one.get(key)
        room = REACH if limit is None else abs(limit - one["value"]) / one["sigma"]
        ends.append(f"{sign * min(REACH, room):.2f}")
    return {"number": number, "name": one["name"], "low": ends[0], "high": ends[1],
            "value": f"{one['value']:.5g}"}  # fmt: skip
