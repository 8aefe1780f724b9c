"""The tables of published figures and of what one set of values has to give."""

from collections.abc import Sequence

from thesis.figure import BEF, CONVENTIONAL, MPF_PRINTED, PATTERNED, PLATE_PRINTED, Figure, Figures
from thesis.table import table

_NEAR_CONTRAST, _NEAR_LUMINANCE, _NEAR_CURVATURE = 0.003, 0.01, 5.0


def compare(figures: Sequence[Figures], names: Sequence[str]) -> str:
    """Return the table of published figures, profile, ours and verdict for each set."""
    columns = [_compared(f) for f in figures]
    rows = []
    for lines in zip(*columns, strict=True):
        cells = [*lines[0][:3]]
        for line in lines:
            cells += line[3:]
        rows.append(cells)
    head = ["figure", "published", "profile"]
    for name in names:
        head += [f"`{name}`", "verdict"]
    return table(head, rows)


def _compared(of: Figures) -> list[tuple[str, ...]]:
    """Return (figure, published, profile, ours, verdict) of each published figure."""

    def contrast(what: str, published: float, case: str, profile: str) -> tuple[str, ...]:
        ours = of.contrast(case)
        verdict = ours.beside(published, 0.0005, _NEAR_CONTRAST)
        return what, f"{published:.3f}", profile, ours.show(4), verdict

    def luminance(what: str, published: float, case: str) -> tuple[str, ...]:
        ours = of.relative(case)
        verdict = ours.beside(published / 6875, 0.5 / 6875, _NEAR_LUMINANCE)
        return (what, f"{published:.0f} cd/m², {published / 6875:.4f}", "ideal", ours.show(4),
                verdict)  # fmt: skip

    def curvature(what: str, published: float, name: str, about: float) -> tuple[str, ...]:
        ours = of.place("mpf", name)
        shown = ours.show(0)
        if name != "best_per_mm":
            # The surfaces end where the traces do: the range may go on.
            shown = shown.replace("50 (", "≤ 50 (", 1) if ours.value <= 50 else shown
            shown = shown.replace("81 (", "≥ 81 (", 1) if ours.value >= 81 else shown
        text = f"about {published:.0f} /mm" if about else f"{published:.0f} /mm"
        return what, text, "ideal", shown, ours.beside(published, 0.5, _NEAR_CURVATURE)

    def yes(what: str, published: str, profile: str, ours: str, holds: bool) -> tuple[str, ...]:
        return what, published, profile, ours, "agrees" if holds else "differs"

    def below(what: str, limit: float, profile: str, ours: Figure) -> tuple[str, ...]:
        verdict = "agrees" if ours.high < limit else "differs" if ours.low > limit else "open"
        return what, f"below {limit:g}", profile, ours.show(4), verdict

    level = of.luminance(CONVENTIONAL)
    fall = of.relative("mpf ideal 81", "mpf ideal 70")
    rise = of.relative("mpf ideal 70", "mpf ideal 60")
    plate_fall = of.relative("mpf-plate ideal 81", "mpf-plate ideal 67")
    bef = of.contrast(BEF)
    between = of.is_brighter_between(BEF)
    printed = of.relative(MPF_PRINTED)
    fuller = of.relative("mpf filled 45.13", MPF_PRINTED)
    slim = of.contrast(PATTERNED)
    return [
        contrast("conventional: contrast", 0.012, CONVENTIONAL, "filled (BEF)"),
        ("conventional: luminance", "6875 cd/m²", "filled (BEF)", level.show(0),
         level.beside(6875, 0.5, 69)),
        curvature("MPF: good range (contrast ≤ 0.012) begins", 57, "range_low_per_mm", 0),
        curvature("MPF: good range ends", 81, "range_high_per_mm", 0),
        curvature("MPF: best curvature", 60, "best_per_mm", 1),
        luminance("MPF, C = 60: luminance", 7243, "mpf ideal 60"),
        below("MPF: luminance falls above 70 /mm: L(81)/L(70)", 1, "ideal", fall),
        yes("MPF: and not before: L(70)/L(60)", "about 1", "ideal", rise.show(4), rise.high >= 1),
        contrast("MPF-Plate, C = 60: contrast closest to conventional", 0.012,
                 "mpf-plate ideal 60", "ideal"),
        luminance("MPF-Plate, C = 60: luminance", 7070, "mpf-plate ideal 60"),
        below("MPF-Plate: luminance falls above 67 /mm: L(81)/L(67)", 1, "ideal", plate_fall),
        contrast("MPF, 10 % fill: contrast", 0.010, MPF_PRINTED, "filled"),
        contrast("MPF-Plate, 10 % fill: contrast", 0.018, PLATE_PRINTED, "filled"),
        below("MPF, 10 % fill: luminance", 1, "filled", printed),
        below("MPF: luminance falls as fill rises: L(25 %)/L(10 %)", 1, "filled", fuller),
        yes("BEF in the MPF's place: contrast", "visible (above 0.018)", "filled (BEF)",
            bef.show(4), bef.low > 0.018),
        yes("BEF in the MPF's place: brighter", "between lamps", "filled (BEF)",
            "between lamps" if between else "above lamps", between),
        below("patterned, 16 mm (`masks/patterned-16mm.toml`): contrast", 0.018, "filled", slim),
    ]  # fmt: skip


def demands(figures: Sequence[Figures], names: Sequence[str]) -> str:
    """Return the table of demands on one set of values: met or not, by each set."""
    rows = []
    for lines in zip(*(_demanded(f) for f in figures), strict=True):
        cells = [lines[0][0]]
        for _, shown, met in lines:
            cells += [shown, "met" if met else "NOT MET"]
        rows.append(cells)
    head = ["demand"]
    for name in names:
        head += [f"`{name}`", ""]
    return table(head, rows)


def _demanded(of: Figures) -> list[tuple[str, str, bool]]:
    """Return (demand, ours, met) of each demand."""
    conventional = of.contrast(CONVENTIONAL)
    film = of.contrast("mpf ideal 65")
    best = of.place("mpf", "best_per_mm")
    level = of.relative("mpf ideal 60")
    fall = of.relative("mpf ideal 81", "mpf ideal 70")
    plate = of.relative("mpf-plate ideal 60", "mpf ideal 60")
    bef, printed = of.contrast(BEF), of.contrast(MPF_PRINTED)

    def within(figure: Figure, low: float, high: float) -> bool:
        return low <= figure.value <= high

    return [
        ("conventional contrast ≤ 0.015", conventional.show(4), conventional.is_at_most(0.015)),
        ("MPF contrast below conventional's or ≤ 0.012 somewhere in C = 57 … 81: at 65",
         film.show(4), film.is_at_most(max(0.012, conventional.value))),
        ("its minimum between 55 and 75 /mm", best.show(0), within(best, 55, 75)),
        ("MPF luminance at C = 60 in 1.02 … 1.09", level.show(4), within(level, 1.02, 1.09)),
        ("falling above 70: L(81)/L(70) < 1", fall.show(4), fall.high < 1),
        ("MPF-Plate 1 … 4 % below MPF at C = 60", plate.show(4), within(plate, 0.96, 0.99)),
        ("BEF in the MPF's place above 0.018 and brighter between the lamps", bef.show(4),
         bef.low > 0.018 and of.is_brighter_between(BEF)),
        ("MPF at 10 % fill ≤ 0.018", printed.show(4), printed.is_at_most(0.018)),
    ]  # fmt: skip
