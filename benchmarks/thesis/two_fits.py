"""The two fits of `mpfcad fit`: to the thesis's simulated figures, and to its measured ones."""

from thesis.table import table

NAMES = ("simulated", "measured")
_SIGN = {"equal": "", "at_least": "≥ ", "at_most": "≤ "}


def two_fits(fits: dict[str, dict]) -> str:
    """Return the section in Markdown from the records of `fit-simulated` and `fit-measured`."""
    efforts = " and ".join(f"`{fits[name]['effort']}`" for name in NAMES)
    paths = " and ".join(f"{fits[name]['paths'] / 1e6:.0f}" for name in NAMES)
    parts = [
        "Made by `mpfcad fit benchmarks/thesis/fit-simulated.toml` and `fit-measured.toml`\n"
        f"([fit.md](fit.md)), effort {efforts}, {paths} million paths. The first is the preset\n"
        "`thesis-fitted`. Intervals hold what is not known of the values and the traces' noise.\n"
        "The simulated luminances are higher than the measured ones: the thesis blames its\n"
        "simulation by 5 to 12 %.\n",
        "Values, and the share of the prior's width that the figures leave:\n",
        _values(fits),
    ]
    for name in NAMES:
        parts += _one(name, fits[name])
    parts += ["### What each predicts of what it was not given\n", _predictions(fits)]
    parts.append(_thickness(fits))
    return "\n".join(parts)


def _one(name: str, fit: dict) -> list[str]:
    """Return how one fit meets its figures, what it holds, and what would hold more."""
    chi2, freedom = fit["chi2"], fit["degrees_of_freedom"]
    word = " They contradict each other." if fit["contradicts"] else ""
    held = "\n".join(
        f"* ± {entry['width']:.2g} of its prior: {_combination(entry['parts'])}"
        for entry in fit["combinations"]
    )
    best = min(fit["measure_next"], key=lambda row: row["left"], default=None)
    after = (
        f"\nTo measure next: {best['measurement']}; it would leave {best['left']:.2f} of the\n"
        "predictions' widths.\n" if best else ""
    )  # fmt: skip
    return [
        f"### To the {name} figures\n",
        f"χ² is {chi2:.1f} of {freedom}, probability {fit['probability']:.2f}.{word}\n",
        _data(fit),
        "Combinations of values that these figures hold, best first:\n",
        held + "\n" + after,
    ]


def _combination(weight: dict[str, float]) -> str:
    parts = sorted(weight.items(), key=lambda item: -abs(item[1]))[:4]
    return ", ".join(f"{value:+.2f} `{name}`" for name, value in parts)


def _values(fits: dict[str, dict]) -> str:
    rows = []
    for pair in zip(*(fits[name]["values"] for name in NAMES), strict=True):
        first = pair[0]
        free = first["prior_sigma"] is None
        cells = [
            f"`{first['name']}`",
            "none" if free else f"{first['prior']:.4g} ± {first['prior_sigma']:.2g}",
        ]
        for row in pair:
            left = "" if row["left"] is None else f", {100 * row['left']:.0f} %"
            cells.append(f"{row['value']:.4g} ± {row['sigma']:.2g}{left}")
        rows.append(cells)
    return table(["value", "prior", "to the simulated", "to the measured"], rows)


def _data(fit: dict) -> str:
    rows = [
        [row["name"], f"{_SIGN[row['kind']]}{row['measured']:.5g} ± {row['sigma']:.2g}",
         f"{row['predicted']:.4g} ± {row['predicted_sigma']:.2g}", f"{row['residual']:+.1f}"]
        for row in fit["data"]
    ]  # fmt: skip
    return table(["figure", "published", "fitted", "off [σ]"], rows)


def _predictions(fits: dict[str, dict]) -> str:
    found = {name: {p["name"]: p for p in fits[name]["predictions"]} for name in NAMES}
    names = list(dict.fromkeys(key for name in NAMES for key in found[name]))

    def shown(row: dict | None) -> str:
        if row is None:
            return "given"
        return f"{row['value']:.4g} ({row['ci95'][0]:.4g} … {row['ci95'][1]:.4g})"

    rows = [[key, *(shown(found[name].get(key)) for name in NAMES)] for key in names]
    return table(["figure", "by the simulated", "by the measured"], rows)


def _thickness(fits: dict[str, dict]) -> str:
    """Return at which thickness the patterned film is as bright as the conventional stack."""
    words = []
    for name in NAMES:
        rows = [p for p in fits[name]["predictions"] if p["name"].startswith("patterned")]
        values = [row["value"] for row in rows]
        inside = min(values) <= 1 <= max(values)
        sure = all(row["ci95"][0] > 1 or row["ci95"][1] < 1 for row in rows)
        if inside:
            words.append(f"by the {name} figures it crosses 1 between 10 and 16 mm")
        else:
            side = "above" if values[0] > 1 else "below"
            words.append(f"by the {name} figures it stays {side} 1 from 16 to 10 mm"
                         + ("" if sure else ", though its interval holds 1"))  # fmt: skip
    return (
        "The thickness at which the patterned film's mean falls to the conventional 6875 cd/m²\n"
        "(ratio 1; the map of `masks/patterned-16mm.toml` at each thickness):\n\n"
        + "".join(f"* {word};\n" for word in words)
        + "\nThe ratio hardly follows the thickness, so these fits name none.\n"
    )
