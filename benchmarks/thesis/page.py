"""The page of the reproduction, made of the results and the fits alone."""

from thesis.comparison import compare, demands
from thesis.figure import PATTERNED, Figures
from thesis.fill_table import fill_section
from thesis.film_table import film_table
from thesis.two_fits import two_fits

SETS = ("thesis-32in", "thesis-fitted")

_HEAD = """# The thesis beside ours

Made by `python benchmarks/reproduce.py` from `benchmarks/thesis/results.json` (traced) and the two
fits `fit-simulated.json` and `fit-measured.json` (`mpfcad fit`). Published: Hsieh, *A
Multi-Performance Film for Highly Efficient LCD Backlights*, master's thesis, NCTU. Do not edit by
hand.

Simulated figures of the thesis stand beside the `ideal` profile (the pure parabola), measured ones
beside `filled` (what a printed resin can make). Contrast is (Lmax - Lmin)/(Lmax + Lmin) over the
central lamp pitch (eq. 10), without the bias of a noisy maximum ([intervals.md](intervals.md));
luminance is its mean there over that of the conventional stack. In brackets: 95 % intervals of the
Monte-Carlo noise alone. Two sets of assumed values are shown: `thesis-32in-*`, the presets, and
`thesis-fitted-*`, the set that the fit to the simulated figures finds.

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


def page(results: dict, fits: dict[str, dict], picture: str) -> str:
    """Return the page in Markdown; `picture` is the name of the drawing beside it.

    `fits`: the records of `mpfcad fit` to the simulated and to the measured figures.
    """
    figures = [Figures(results, name) for name in SETS]
    parts = [
        _HEAD,
        _effort(results, figures),
        "## Published and ours\n",
        compare(figures, SETS),
        f"![Contrast and luminance against curvature]({picture})\n",
        "Points: single traces. Lines: parabolas through their mean and harmonics, with 95 %\n"
        "bands; the good range and the best curvature above are read off them.\n",
        "## What one set of values has to give\n",
        "Met by our value, and by its whole 95 % interval (`open`: it includes a limit).\n",
        demands(figures, SETS),
        _trade(figures),
        "## Particles in the fill\n",
        fill_section(figures, SETS),
        "## Slim backlights\n",
        _SLIM,
        "## The film itself\n",
        film_table(),
        "## Two fits: to the simulated figures, and to the measured ones\n",
        two_fits(fits),
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
