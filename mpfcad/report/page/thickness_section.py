"""Which thickness a film serves, how bright it is, and what would help: in words and curves."""

from typing import TYPE_CHECKING, Any

from mpfcad.report.drawing.figure import FILM_COLOUR, line, styled
from mpfcad.report.drawing.plot import plot
from mpfcad.report.page.number import with_interval

if TYPE_CHECKING:
    import plotly.graph_objects as go


_FILM = {"filled": "The printed", "ideal": "The moulded"}


def limit_words(limit: dict[str, Any]) -> list[str]:
    """Return what the traced films of several thicknesses say together, a sentence each."""

    def listed(key: str) -> str:
        return ", ".join(f"{t:g}" for t in limit[key])

    allowed = f"{limit['contrast_limit']:g}"
    film = _FILM[limit["profile"]]
    words = []
    if limit["serves_mm"]:
        words.append(
            f"{film} film serves {listed('serves_mm')} mm: contrast within {allowed}, interval and "
            f"all."
        )
    else:
        words.append(f"{film} film serves no thickness that was traced.")
    if limit["undecided_mm"]:
        words.append(f"Not decided (the interval holds {allowed}): {listed('undecided_mm')} mm.")
    if limit["fails_mm"]:
        words.append(
            f"{film} film that was found does not serve {listed('fails_mm')} mm: its contrast is "
            f"above {allowed} with 95 % confidence."
        )
    conventional = f"the conventional stack's {limit['conventional_luminance_cd_m2']:.0f} cd/m²"
    low, high = limit["relative_luminance"]
    if limit["equal_luminance_mm"]:
        equal = " and ".join(f"{t:.1f}" for t in limit["equal_luminance_mm"])
        words.append(f"Mean luminance equals {conventional} at {equal} mm.")
    else:
        side = "above" if low > 1 else "below"
        words.append(
            f"Mean luminance is {side} {conventional} at every thickness: {low:.3f} … {high:.3f} "
            f"of it."
        )
    return words


def range_words(found: dict[str, Any]) -> list[str]:
    """Return what a design over a range of thickness found, a sentence each."""
    least, span = found["least_mm"], f"{found['min_mm']:g} … {found['max_mm']:g} mm"
    if least is None:
        words = [f"No thickness of {span} serves."]
    else:
        words = [f"Least thickness that serves, of {span}: {least:g} mm."]
    words += limit_words(found["limit"])
    words += [_bound_words(one, found) for one in found["bounds"]]
    return words + _help_words(found)


def _bound_words(one: dict[str, Any], found: dict[str, Any]) -> str:
    """Return what no map goes below at a thickness, and plainly whether that decides it."""
    words = f"no map of C in the range has a contrast below {one['contrast_bound']:.4f}, by the "
    words += (
        "model corrected by its traces" if one["corrected"] else "model, which no trace corrects"
    )
    if one["contrast_bound"] > found["contrast_limit"]:
        film = _FILM[found["limit"]["profile"]]
        return f"{film} film cannot serve {one['thickness_mm']:g} mm: {words}."
    return f"At {one['thickness_mm']:g} mm {words}."


def _help_words(found: dict[str, Any]) -> list[str]:
    """Return which of the changes tried would let the least thickness of the range serve."""
    if not found["remedies"]:
        return []
    limit = found["contrast_limit"]
    good = [
        f"{change_words(one)} ({one['lamp_mura_contrast']:.4f}, "
        f"{one['mean_luminance_cd_m2']:.0f} cd/m²)"
        for one in found["remedies"][1:]
        if one["lamp_mura_contrast"] <= limit
    ]
    at = f"At {found['remedies'][0]['thickness_mm']:g} mm"
    if good:
        return [f"{at} it would do, by the model, with {' or with '.join(good)}."]
    return [f"{at} no single change that was tried would do, by the model."]


def change_words(remedy: dict[str, Any]) -> str:
    """Return the values of the stack that are changed, in words."""
    return ", ".join(f"{k} = {v:.6g}" for k, v in remedy["override"].items()) or "as it is"


def thickness_values(found: dict[str, Any]) -> dict[str, Any]:
    """Return what the section of a design over a range of thickness shows."""
    return {
        "words": range_words(found),
        "plot": plot(thickness_figure(found), "thickness"),
        "points": [_point_row(point) for point in found["points"]],
        "remedies": [_remedy_row(one) for one in found["remedies"]],
    }


def _point_row(point: dict[str, Any]) -> list[str]:
    model, traced = point["model"], point["traced"]
    return [
        f"{point['thickness_mm']:g}",
        f"{model['lamp_mura_contrast']:.4f}",
        f"{model['mean_luminance_cd_m2']:.0f}",
        with_interval(traced["lamp_mura_contrast"], 4) if traced else "–",
        with_interval(traced["mean_luminance_cd_m2"], 0) if traced else "–",
        traced["outcome"] if traced else "–",
    ]


def _remedy_row(one: dict[str, Any]) -> list[str]:
    return [
        f"{one['thickness_mm']:g}",
        change_words(one),
        f"{one['lamp_mura_contrast']:.4f}",
        f"{one['mean_luminance_cd_m2']:.0f}",
    ]


def thickness_figure(found: dict[str, Any]) -> "go.Figure":
    """Return contrast and mean luminance over the thickness, by the model and as traced."""
    from plotly.subplots import make_subplots

    made = make_subplots(
        rows=1,
        cols=2,
        horizontal_spacing=0.1,
        subplot_titles=("lamp-Mura contrast", "mean normal luminance [cd/m²]"),
    )
    points = found["points"]
    traced = [point for point in points if point["traced"]]
    for column, key in ((1, "lamp_mura_contrast"), (2, "mean_luminance_cd_m2")):
        made.add_scatter(
            x=[point["thickness_mm"] for point in points],
            y=[round(point["model"][key], 6) for point in points],
            name="model",
            mode="lines",
            line=line("#b9c4cf", 2),
            showlegend=column == 1,
            row=1,
            col=column,
        )
        values = [point["traced"][key] for point in traced]
        made.add_scatter(
            x=[point["thickness_mm"] for point in traced],
            y=[round(v["value"], 6) for v in values],
            error_y={
                "type": "data",
                "array": [round(v["ci95"][1] - v["value"], 6) for v in values],
                "arrayminus": [round(v["value"] - v["ci95"][0], 6) for v in values],
            },
            name="traced",
            mode="markers",
            marker={"size": 8, "color": FILM_COLOUR},
            showlegend=column == 1,
            row=1,
            col=column,
        )
    dotted = line("#777", 1, "dot")
    made.add_hline(found["contrast_limit"], line=dotted, row=1, col=1)
    conventional = found["limit"]["conventional_luminance_cd_m2"]
    made.add_hline(conventional, line=dotted, row=1, col=2)
    made.update_xaxes(title_text="thickness [mm]")
    made.update_yaxes(rangemode="tozero", row=1, col=1)
    return styled(made, 380)
