"""The page of the reproduction, made of the results and the fit alone."""

from thesis.comparison import compare, demands
from thesis.figure import PATTERNED, Figures
from thesis.film_table import film_table
from thesis.table import table
from thesis.trial import FACTORS

SETS = ("thesis-32in", "thesis-fitted")

_HEAD = """# The thesis beside ours

Made by `python benchmarks/reproduce.py` from `benchmarks/thesis/results.json` (traced),
`fit.json` (`python benchmarks/fit_stack.py`) and `published.toml` (Hsieh, *A Multi-Performance Film
for Highly Efficient LCD Backlights*, master's thesis, NCTU). Do not edit by hand.

Simulated figures of the thesis stand beside the `ideal` profile (the pure parabola), measured ones
beside `filled` (what a printed resin can make). Contrast is (Lmax - Lmin)/(Lmax + Lmin) over the
central lamp pitch (eq. 10), without the bias of a noisy maximum ([tracing.md](tracing.md));
luminance is its mean there over that of the conventional stack. In brackets: 95 % intervals of the
Monte-Carlo noise alone. Two sets of assumed values are shown: `thesis-32in-*`, the presets, and
`thesis-fitted-*`, the set that this page's fit finds.

`agrees`: the published figure lies in our interval widened by its rounding. `near`: within 0.003 of
contrast, 1 % of luminance or 5 /mm. `differs`: neither. `open`: the interval lies on both sides of
a published limit.
"""


def page(results: dict, fit: dict, picture: str) -> str:
    """Return the page in Markdown; `picture` is the name of the drawing beside it."""
    figures = [Figures(results, fit, name) for name in SETS]
    parts = [
        _HEAD,
        "## Published and ours\n",
        compare(figures, SETS),
        f"![Contrast and luminance against curvature]({picture})\n",
        "Lines: response surfaces of the fit with their 95 % bands; points: single traces.\n",
        "## What one set of values has to give\n",
        "Met where the value keeps the limit; the minimum is read off the response surface.\n",
        demands(figures, SETS),
        _trade(figures),
        "## The film itself\n",
        film_table(),
        "## The fit\n",
        _fit(fit),
        "## What a difference hangs on\n",
        _sensitivity(fit),
        _LEFT,
    ]
    return "\n".join(parts).rstrip() + "\n"


def _trade(figures: list[Figures]) -> str:
    preset, fitted = figures
    lines = [
        f"{name}: {one.contrast(case).show(4)} in `{SETS[0]}`, {two.contrast(case).show(4)} in "
        f"`{SETS[1]}`"
        for name, case, one, two in (
            ("`masks/uniform-c60.toml`", "mpf filled 60", preset, fitted),
            ("`masks/patterned-16mm.toml`", PATTERNED, preset, fitted),
        )
    ]
    return f"""
The presets `thesis-32in-*` keep their values although `thesis-fitted-*` lies closer to the
published figures: the jobs in `masks/` were designed with them. Contrast of those films in both:

* {lines[0]};
* {lines[1]}.

So a film that passes (at most 0.012) in one backlight that fits the thesis need not in another: its
verdict is as good as the stack's values, and these have to be measured.
"""


def _fit(fit: dict) -> str:
    rows = []
    for row, factor in zip(fit["values"], FACTORS, strict=True):
        ends = [
            "–" if abs(factor.code(end)) > 0.999 * fit["reach"] else f"{end:.3g}"
            for end in row["interval"]
        ]
        alone = [
            "–" if abs(code) >= fit["reach"] else f"{factor.value(code):.3g}"
            for code in row["data_interval_code"]
        ]
        rows.append(
            [f"`{row['name']}`", f"{row['centre']:.4g}",
             f"{row['low_step']:.3g}, {row['high_step']:.3g}", f"{row['fitted']:.4g}",
             " … ".join(ends), " … ".join(alone), f"{100 * row['held']:.0f} %"]
        )  # fmt: skip
    values = table(
        ["value", "`thesis-32in`", "a step down, up", "fitted", "95 %", "data alone", "held"],
        rows,
    )
    directions = "\n".join(
        f"* ±{1 / d['singular']:.2g} steps: " + _combination(d["combination"])
        for d in fit["directions"]
    )
    count = len(FACTORS) - len(fit["directions"])
    signs = {"equal": "", "at_most": "≤ ", "at_least": "≥ "}
    aims = table(
        ["figure", "published", "`thesis-32in`", "fitted", "standard error", "fitted is off by"],
        [
            [row["name"], f"{signs[row['kind']]}{row['published']:.4f}", f"{row['at_centre']:.4f}",
             f"{row['fitted']:.4f}", f"{row['standard_error']:.4f}", f"{row['residual']:+.1f} σ"]
            for row in fit["targets"]
        ],
    )  # fmt: skip
    return f"""{fit["trials"]} stacks, all values moved at once by a step up or down (Plackett and
Burman's design and its mirror image) or none; 12 films in each; {fit["paths_a_trace"]:,} paths a
trace. Log luminance and four harmonics of each film follow the values by a linear surface; contrast
is read off the harmonics. The fit minimises the squared distance to the published figures, each
over its rounding, our noise and an allowance for what no model can know of the thesis's lost data
(`published.toml`), with a prior of one step about the presets' values. The lamps' luminance follows
from 6875 cd/m².

{values}
*95 %*: profile interval with the prior; *data alone*: without it; – where it does not end within
the ±{fit["reach"]:g} steps that the surfaces reach. *Held*: share of the prior's variance
that the data take away.

What it aims at, read off the surfaces (luminance relative to conventional; σ holds the allowance):

{aims}
Combinations that the data hold, best first; the other {count} are free, so many sets do as well:

{directions}
"""


def _combination(weight: dict[str, float]) -> str:
    parts = sorted(weight.items(), key=lambda item: -abs(item[1]))[:4]
    return ", ".join(f"{value:+.2f} `{name}`" for name, value in parts)


def _sensitivity(fit: dict) -> str:
    targets = [row["name"] for row in fit["targets"]]
    found = {(row["target"], row["value"]): row for row in fit["sensitivity"]}
    rows = []
    for factor in FACTORS:
        cells = [f"`{factor.name}` {_step(factor)}"]
        for target in targets:
            entry = found[target, factor.name]
            strong = abs(entry["change"]) > 2 * entry["standard_error"]
            text = f"{1000 * entry['change']:+.1f}"
            cells.append(f"**{text}**" if strong else text)
        rows.append(cells)
    head = ["one step up", *targets]
    return f"""Change × 1000 of each figure for one step up of each value about the presets'
values; bold: more than two standard errors.

{table(head, rows)}
To bring the presets' figure to the published one by a single value:

{_remedies(fit, found)}
{_turns(fit)}"""


def _remedies(fit: dict, found: dict) -> str:
    """Return for each figure that is off the three values that would mend it with least ado."""
    lines = []
    for row in fit["targets"]:
        wanted = row["published"] - row["at_centre"]
        if row["kind"] != "equal" or abs(row["residual_at_centre"]) < 1:
            continue
        steps = sorted(
            ((wanted / found[row["name"], f.name]["change"], f.name) for f in FACTORS),
            key=lambda item: abs(item[0]),
        )
        mended = ", ".join(f"`{name}` {count:+.1f} steps" for count, name in steps[:3])
        ours = f"{row['at_centre']:.4f}, published {row['published']:.4f}"
        lines.append(f"* {row['name']} ({ours}): {mended}")
    return "\n".join(lines) + "\n"


def _turns(fit: dict) -> str:
    """Return what moves the fall of luminance with curvature."""
    lines = []
    for row in fit["turns"]:
        high, low = row["curvatures_per_mm"]
        film = {"mpf": "MPF", "plate": "MPF-Plate"}[row["family"]]
        lines.append(
            f"* {film}, L({high:g})/L({low:g}): {row['at_centre']:.4f} and {row['fitted']:.4f}; "
            f"`{row['moved_most_by']}` moves it most, by {row['change']:+.4f} a step"
        )
    head = "Where luminance begins to fall hardly hangs on the stack's values (presets', fitted):"
    return head + "\n\n" + "\n".join(lines) + "\n"


def _step(factor) -> str:
    return f"× {factor.step:g}" if factor.ratio else f"+ {factor.step:g}"


_LEFT = """
## Not reproduced

* Printed films darker than conventional, and darker the more they are filled beyond what the shape
  does: the thesis blames particles in the resin (10⁵ /mm³). Ours here have clear resin: particles
  can be given ([stack.md](stack.md)), but the thesis's text leaves out their radius and index.
* Patterned films below 16 mm: `mpfcad design` finds their maps.
* The thesis's measured scattering tables are lost; sheets, plate and reflector are models here.
"""
