"""The tables of published figures and of what one set of values has to give."""

from collections.abc import Sequence

from thesis.by_curvature import CURVATURE
from thesis.figure import BEF, CONVENTIONAL, MPF_PRINTED, PATTERNED, PLATE_PRINTED, Figure, Figures
from thesis.table import table

#: Particles in the fill: stack, resin, curvature; beside the clear film of the same fill.
_PARTICLES = {
    "MPF, 100 % fill: luminance with particles over clear, Mie": ("mpf", "mie", 0.0),
    "the same, g = 0.5": ("mpf", "g", 0.0),
    "the same, g = 0.5, without top sheet": ("mpf-no-top", "g", 0.0),
}
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
        verdict = ours.beside(published, 0.0005, _NEAR_CONTRAST, 4)
        return what, f"{published:.3f}", profile, ours.show(4), verdict

    def luminance(what: str, published: float, case: str) -> tuple[str, ...]:
        ours = of.relative(case)
        verdict = ours.beside(published / 6875, 0.5 / 6875, _NEAR_LUMINANCE, 4)
        return (what, f"{published:.0f} cd/m², {published / 6875:.4f}", "ideal", ours.show(4),
                verdict)  # fmt: skip

    def curvature(what: str, published: float, name: str, about: float) -> tuple[str, ...]:
        ours = of.place("mpf", name)
        shown, verdict = ours.show(0), ours.beside(published, 0.5, _NEAR_CURVATURE, 0)
        if name != "best_per_mm":
            # The lines end where the traces do: the range may go on.
            for end, sign in ((CURVATURE[0], "≤"), (CURVATURE[-1], "≥")):
                if end in (ours.value, ours.low, ours.high):
                    verdict = "open, the traces end here"
                if ours.value == end:
                    shown = f"{sign} {shown}"
        text = f"about {published:.0f} /mm" if about else f"{published:.0f} /mm"
        return what, text, "ideal", shown, verdict

    def beyond(
        what: str, limit: float, profile: str, ours: Figure, *, above: bool = False
    ) -> tuple[str, ...]:
        side = "above" if above else "below"
        verdict = ours.beyond(limit, above=above)
        return what, f"{side} {limit:g}", profile, ours.show(4), verdict

    level = of.luminance(CONVENTIONAL)
    fall = of.relative("mpf ideal 81", "mpf ideal 70")
    rise = of.relative("mpf ideal 70", "mpf ideal 60")
    plate_fall = of.relative("mpf-plate ideal 81", "mpf-plate ideal 67")
    cosine = of.first_harmonic(BEF)
    printed = of.relative(MPF_PRINTED)
    fuller = of.relative("mpf filled 45.13", MPF_PRINTED)
    return [
        contrast("conventional: contrast", 0.012, CONVENTIONAL, "filled (BEF)"),
        ("conventional: luminance", "6875 cd/m²", "filled (BEF)", level.show(0),
         level.beside(6875, 0.5, 69, 0)),
        curvature("MPF: good range (contrast ≤ 0.012) begins", 57, "range_low_per_mm", 0),
        curvature("MPF: good range ends", 81, "range_high_per_mm", 0),
        curvature("MPF: best curvature", 60, "best_per_mm", 1),
        luminance("MPF, C = 60: luminance", 7243, "mpf ideal 60"),
        beyond("MPF: luminance falls above 70 /mm: L(81)/L(70)", 1, "ideal", fall),
        ("MPF: and not before: L(70)/L(60)", "about 1", "ideal", rise.show(4),
         rise.beside(1, 0.0005, _NEAR_LUMINANCE, 4)),
        contrast("MPF-Plate, C = 60: contrast closest to conventional", 0.012,
                 "mpf-plate ideal 60", "ideal"),
        luminance("MPF-Plate, C = 60: luminance", 7070, "mpf-plate ideal 60"),
        beyond("MPF-Plate: luminance falls above 67 /mm: L(81)/L(67)", 1, "ideal", plate_fall),
        contrast("MPF, 10 % fill: contrast", 0.010, MPF_PRINTED, "filled"),
        contrast("MPF-Plate, 10 % fill: contrast", 0.018, PLATE_PRINTED, "filled"),
        beyond("MPF, 10 % fill: luminance", 1, "filled", printed),
        beyond("MPF: luminance falls as fill rises: L(25 %)/L(10 %)", 1, "filled", fuller),
        beyond("BEF in the MPF's place: visible contrast", 0.018, "filled (BEF)",
               of.contrast(BEF), above=True),
        ("BEF in the MPF's place: brighter", "between lamps", "filled (BEF)",
         f"{'between' if cosine.value < 0 else 'above'} lamps, cos 2πu: {cosine.show(4)}",
         cosine.beyond(0, above=False)),
        *(beyond(what, 1, "filled", of.fill_ratio(*case)) for what, case in _PARTICLES.items()),
        beyond("patterned, 16 mm (`masks/patterned-16mm.toml`): contrast", 0.018, "filled",
               of.contrast(PATTERNED)),
    ]  # fmt: skip


def demands(figures: Sequence[Figures], names: Sequence[str]) -> str:
    """Return the table of demands on one set of values: met by value, by interval, by each set."""
    rows = []
    for lines in zip(*(_demanded(f) for f in figures), strict=True):
        cells = [lines[0][0]]
        for _, shown, (value, interval) in lines:
            cells += [shown, f"{'met' if value else 'NOT MET'} / {interval}"]
        rows.append(cells)
    head = ["demand"]
    for name in names:
        head += [f"`{name}`", "value / interval"]
    return table(head, rows)


def _demanded(of: Figures) -> list[tuple[str, str, tuple[bool, str]]]:
    """Return (demand, ours, (met by the value, by the interval)) of each demand."""
    conventional = of.contrast(CONVENTIONAL)
    lowest, best = of.lowest("mpf"), of.place("mpf", "best_per_mm")
    bef, cosine = of.contrast(BEF), of.first_harmonic(BEF)

    def demand(what: str, ours: Figure, low: float, high: float, digits: int = 4) -> tuple:
        return what, ours.show(digits), ours.keeps(low, high)

    ratio = of.relative
    return [
        demand("conventional contrast ≤ 0.015", conventional, 0, 0.015),
        demand("MPF contrast below conventional's or ≤ 0.012 somewhere in C = 57 … 81: at 65",
               of.contrast("mpf ideal 65"), 0, max(0.012, conventional.value)),
        demand("the same where the line through the traces is lowest", lowest, 0, 0.012),
        demand("its minimum between 55 and 75 /mm", best, 55, 75, 0),
        demand("MPF luminance at C = 60 in 1.02 … 1.09", ratio("mpf ideal 60"), 1.02, 1.09),
        demand("falling above 70: L(81)/L(70) < 1", ratio("mpf ideal 81", "mpf ideal 70"), 0, 1),
        demand("MPF-Plate 1 … 4 % below MPF at C = 60",
               ratio("mpf-plate ideal 60", "mpf ideal 60"), 0.96, 0.99),
        demand("BEF in the MPF's place: contrast above 0.018", bef, 0.018, 1),
        demand("and brighter between the lamps: share of cos 2πu below 0", cosine, -1, 0),
        demand("MPF at 10 % fill: contrast ≤ 0.018", of.contrast(MPF_PRINTED), 0, 0.018),
    ]  # fmt: skip
