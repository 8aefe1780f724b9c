"""The page of the reproduction, made of the results and the fit alone."""

from thesis.comparison import compare, demands
from thesis.figure import PATTERNED, Figures
from thesis.fill_table import fill_section
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
central lamp pitch (eq. 10), without the bias of a noisy maximum ([intervals.md](intervals.md));
luminance is its mean there over that of the conventional stack. In brackets: 95 % intervals of the
Monte-Carlo noise alone. Two sets of assumed values are shown: `thesis-32in-*`, the presets, and
`thesis-fitted-*`, the set that this page's fit finds.

Verdicts rest on those intervals, not on our values alone:

* `agrees, within d`: the published figure lies in our interval widened by its rounding, and no end
  of the interval is further from it than 0.006 of contrast, 2 % of luminance or 10 /mm. d: how far
  the furthest end is, that is what the noise still allows.
* `open, within d`: it lies there, but the interval is wider than that.
* `near`: it does not, but our value is within 0.003 of contrast, 1 % of luminance or 5 /mm.
* Published limits: `agrees, by d or more`: our whole interval keeps it, with d to spare; `open`:
  the interval includes the limit, and the value alone agrees or differs.
* `differs`: neither.
"""


def _effort(results: dict, figures: list[Figures]) -> str:
    """Return how many paths the figures rest on."""
    paths = [count for figure in figures for count in figure.paths()]
    fewest, most = min(paths), max(paths)
    each = f"{fewest:,}" if fewest == most else f"{fewest:,} … {most:,}"
    widths = [f.half_width(name) for f in figures for name in f.case]
    goal, limit = results["half_width_goal"], results["path_limit"]
    return f"""Effort `{results["effort"]}`: whole rounds of paths until there are {limit:,} or
the half-width of the contrast's interval is {goal:g}. That made {each} paths a case, in
{len(paths)} cases, and half-widths of {min(widths):.4f} … {max(widths):.4f}.
"""


def page(results: dict, fit: dict, picture: str) -> str:
    """Return the page in Markdown; `picture` is the name of the drawing beside it."""
    figures = [Figures(results, fit, name) for name in SETS]
    parts = [
        _HEAD,
        _effort(results, figures),
        "## Published and ours\n",
        compare(figures, SETS),
        f"![Contrast and luminance against curvature]({picture})\n",
        "Lines: response surfaces of the fit with their 95 % bands; points: single traces.\n"
        "In `thesis-fitted` the MPF's traces lie about 0.003 of contrast above the surface: noise\n"
        "that traces of one seed share, or curvature of the true surface; the good range and\n"
        "the best curvature above are read off the surface.\n",
        "## What one set of values has to give\n",
        "Met by our value, and by its whole 95 % interval (`open`: it includes a limit). Minimum\n"
        "and surface are read off the fit's response surfaces, which rest on all its traces.\n",
        demands(figures, SETS),
        _trade(figures),
        "## Particles in the fill\n",
        fill_section(figures, SETS),
        "## Slim backlights\n",
        _SLIM,
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


_SLIM = """Published: at 10, 12, 14 and 16 mm a patterned film has a contrast below 0.018.
[design.md](design.md) looks for such films in `thesis-32in-mpf`. At 16 mm it agrees: the film of
`mpfcad design masks/design-16mm.toml`, traced from its exported files, has 0.0000
(0.0000 … 0.0039) and a mean luminance of 7366 cd/m², 1.070 of the conventional stack;
`masks/patterned-16mm.toml`, in the table above, is another. At 14 mm it agrees with the `filled`
profile alone; at 12 and 10 mm it differs, and design.md says what of the backlight would help.
"""

_LEFT = """
## Not reproduced

* A film printed at 10 % fill darker than the conventional stack: ours is brighter with every resin
  tried. Particles darken a fill as much as their phase function is wide, and theirs is lost.
* Patterned films at 12 and 10 mm below 0.018 ([design.md](design.md)).
* The process from screen to fill has one published pair ([process.md](process.md)).
* The thesis's measured scattering tables are lost; sheets, plate and reflector are models here.
"""
