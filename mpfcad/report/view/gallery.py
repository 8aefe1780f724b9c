"""The exports under a folder, and the pages that show them."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mpfcad.export import MANIFEST
from mpfcad.report.drawing.angle_figure import pitch_figure
from mpfcad.report.drawing.figure import BASE_COLOUR, FILM_COLOUR
from mpfcad.report.drawing.plot import plot
from mpfcad.report.film.decision import scale_values, strip_values
from mpfcad.report.page.environment import render
from mpfcad.report.page.number import value_words

#: The page of each kind of export, and its record.
PAGES = {
    "run": ("report.html", "verification.json"),
    "measure": ("measure.html", "measure.json"),
    "compare": ("compare.html", "compare.json"),
    "design": ("design.html", "design.json"),
    "led-design": ("design.html", "design.json"),
    "sweep": ("sweep.html", "sweep.json"),
    "fit": ("fit.html", "fit.json"),
}
#: How deep below the folder exports are looked for.
DEPTH = 4


@dataclass(frozen=True)
class Export:
    """One export.

    Attributes
    ----------
    place
        its folder from the viewed folder on, with slashes; empty for the folder itself
    name, kind
        as its manifest says
    page
        the file to open
    record
        its JSON record, empty where it has none that can be read
    """

    place: str
    name: str
    kind: str
    page: str
    record: dict[str, Any] = field(repr=False)

    @property
    def verdict(self) -> str:
        """PASS, MARGINAL, INCONCLUSIVE or FAIL; empty for an export without."""
        return str(self.record.get("verdict", "")) if self.kind == "run" else ""

    @property
    def address(self) -> str:
        """The page's address from the gallery on."""
        return f"{self.place}/{self.page}" if self.place else self.page


def find_exports(folder: Path) -> list[Export]:
    """Return the exports in a folder and below it, by place; hidden folders are left out."""
    found = []
    for depth in range(DEPTH + 1):
        for manifest in sorted(folder.glob("*/" * depth + MANIFEST)):
            place = manifest.parent.relative_to(folder)
            if not any(part.startswith(".") for part in place.parts):
                export = _read(manifest, place)
                found += [export] if export else []
    return sorted(found, key=lambda one: one.place)


def _read(manifest: Path, place: Path) -> Export | None:
    document = _document(manifest)
    kind = str(document.get("kind", ""))
    page, record = PAGES.get(kind, (MANIFEST, ""))
    if "files" not in document:
        return None
    name = str(document.get("name", manifest.parent.name))
    shown = page if (manifest.parent / page).is_file() else MANIFEST
    where = "" if place == Path() else place.as_posix()
    return Export(where, name, kind, shown, _document(manifest.parent / record) if record else {})


def _document(path: Path) -> dict[str, Any]:
    """Return a JSON table; empty where there is none that can be read."""
    try:
        document = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return document if isinstance(document, dict) else {}


def gallery_page(folder: Path) -> str:
    """Return the page of all exports under a folder, with their verdicts."""
    exports = find_exports(folder)
    scales = {one.place: _scale(one) for one in exports}
    return render(
        "gallery.html.j2",
        folder=folder.name or str(folder),
        runs=[(one, scales[one.place]) for one in exports if scales[one.place]],
        others=[one for one in exports if not scales[one.place]],
    )


def _scale(export: Export) -> dict[str, Any] | None:
    """Return what the scale of a run shows; None of another export, or of another version's."""
    if not export.verdict:
        return None
    try:
        return scale_values(export.record, [("this film", export.record)])
    except (LookupError, TypeError):
        return None


def comparison_page(folder: Path, places: list[str]) -> str | None:
    """Return the page of two runs beside each other; None where they are not both there."""
    runs = {one.place: one for one in find_exports(folder) if one.verdict}
    if len(places) != 2 or not all(place in runs for place in places):
        return None
    chosen = [runs[place] for place in places]
    if not all(one.record.get("curve") or one.record.get("cell") for one in chosen):
        return None  # another version's, or not traced
    names = [one.name if chosen[0].name != chosen[1].name else one.place for one in chosen]
    films = [(name, one.record) for name, one in zip(names, chosen, strict=True)]
    curves = [
        (name, record, colour)
        for (name, record), colour in zip(films, (FILM_COLOUR, BASE_COLOUR), strict=True)
        if record.get("curve")
    ]
    return render(
        "pair.html.j2",
        exports=list(zip(names, chosen, strict=True)),
        scale=scale_values(chosen[0].record, films),
        strips=strip_values(films),
        plot_made=plot(pitch_figure(curves), "pitch") if curves else None,
        inputs=_changed_inputs(*(one.record for one in chosen)),
    )


def _changed_inputs(first: dict[str, Any], second: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return (name, value, value) of the inputs that two runs differ in."""
    values = [{entry["name"]: entry["value"] for entry in one["inputs"]} for one in (first, second)]
    names = list(dict.fromkeys([*values[0], *values[1]]))
    pairs = [(name, values[0].get(name, "–"), values[1].get(name, "–")) for name in names]
    return [(name, value_words(a), value_words(b)) for name, a, b in pairs if a != b]
