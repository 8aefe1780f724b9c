"""Layers with values of their own: more films, plates and sheets than the named ones."""

import re
from dataclasses import dataclass
from pathlib import Path

from mpfcad.errors import InputError

#: What a layer may be by name alone, with what it is in words.
LAYERS = {
    "clear_plate": "clear plate",
    "diffusing_plate": "diffusing plate",
    "bottom_sheet": "bottom diffuser sheet",
    "film": "film",
    "bonded_film": "film bonded on the plate",
    "top_sheet": "top diffuser sheet",
}
_INDEX, _ANGLE, _ABSORPTION, _SLOPE = (1.0, 4.0), (-360.0, 360.0), (0.0, 100.0), (0.0, 1.0)
_SHARE = (0.0, 1.0)
#: Of a Mueller matrix, row by row.
MUELLER_ENTRIES = [f"m{i}{j}" for i in range(4) for j in range(4)]
#: Stands for a value that may be left out, and then is none.
LEFT_OUT = "left out"
#: Values of a layer's own by its kind: lowest, highest, and the stack's value or the number that
#: stands for it where it is left out (None: must be given).
OWN_VALUES: dict[str, dict[str, tuple[float, float, str | float | None]]] = {
    "film": {
        "index": (*_INDEX, "film_index"),
        "rotation_deg": (*_ANGLE, 0.0),
        "absorption_per_mm": (*_ABSORPTION, 0.0),
        "roughness": (*_SLOPE, 0.0),
    },
    "bef": {
        "pitch_um": (1.0, 2000.0, 50.0),
        "depth_um": (1.0, 2000.0, 25.0),
        "base_um": (1.0, 5000.0, 200.0),
        "index": (*_INDEX, "film_index"),
        "rotation_deg": (*_ANGLE, 0.0),
        "absorption_per_mm": (*_ABSORPTION, 0.0),
        "roughness": (*_SLOPE, 0.0),
    },
    "lens": {
        "pitch_um": (1.0, 2000.0, 50.0),
        "sag_um": (0.1, 1000.0, 15.0),
        "base_um": (1.0, 5000.0, 200.0),
        "index": (*_INDEX, "film_index"),
        "rotation_deg": (*_ANGLE, 0.0),
        "absorption_per_mm": (*_ABSORPTION, 0.0),
    },
    "composite": {
        "pitch_um": (1.0, 2000.0, 50.0),
        "depth_um": (1.0, 2000.0, 25.0),
        "base_um": (1.0, 5000.0, 200.0),
        "bond_um": (0.1, 1000.0, None),
        "cover_um": (1.0, 5000.0, 125.0),
        "upper_pitch_um": (1.0, 2000.0, 50.0),
        "upper_depth_um": (0.0, 2000.0, 0.0),
        "index": (*_INDEX, "film_index"),
        "rotation_deg": (*_ANGLE, 0.0),
        "absorption_per_mm": (*_ABSORPTION, 0.0),
    },
    "plate": {
        "thickness_mm": (0.01, 100.0, "plate_thickness_mm"),
        "index": (*_INDEX, "plate_index"),
        "scattering_per_mm": (0.0, 100.0, 0.0),
        "asymmetry": (-0.99, 0.99, 0.0),
        "absorption_per_mm": (0.0, 100.0, 0.0),
    },
    "sheet": {
        "sigma": (0.0, 10.0, None),
        "index": (*_INDEX, "sheet_index"),
        "transmission": (0.0, 1.0, "sheet_transmission"),
        "sigma_across": (0.0, 10.0, LEFT_OUT),
        "axis_deg": (*_ANGLE, LEFT_OUT),
        "wide_sigma": (0.0, 10.0, LEFT_OUT),
        "wide_share": (0.0, 1.0, LEFT_OUT),
        "depolarisation": (*_SHARE, LEFT_OUT),
    },
    "bsdf": {},
    "converter": {
        "absorptance": (0.0, 0.9999, LEFT_OUT),
        "absorption_per_mm": (0.0, 1e5, LEFT_OUT),
        "thickness_um": (0.01, 10_000.0, LEFT_OUT),
        "yield": (0.0, 1.0, None),
        "index": (*_INDEX, 1.5),
        "scattering_per_mm": (0.0, 10_000.0, LEFT_OUT),
        "asymmetry": (-0.99, 0.99, LEFT_OUT),
    },
    "polariser": {
        "axis_deg": (*_ANGLE, 0.0),
        "transmission_along": (*_SHARE, None),
        "transmission_across": (*_SHARE, 0.0),
    },
    "reflective_polariser": {
        "axis_deg": (*_ANGLE, 0.0),
        "transmission_along": (*_SHARE, None),
        "transmission_across": (*_SHARE, None),
        "reflection_along": (*_SHARE, None),
        "reflection_across": (*_SHARE, None),
    },
    "retarder": {
        "axis_deg": (*_ANGLE, 0.0),
        "retardation_nm": (0.0, 1e6, 0.0),
        "retardation_waves": (0.0, 1000.0, 0.0),
    },
    "mueller": {
        "axis_deg": (*_ANGLE, 0.0),
        **{name: (0.0 if name == "m00" else -1.0, 1.0, None) for name in MUELLER_ENTRIES},
    },
}
#: What acts on polarisation: there is none without `light.polarised`.
POLARISING = ("polariser", "reflective_polariser", "retarder", "mueller")
#: What converts light from one wavelength to another.
CONVERTER = "converter"
_FLAGS = ("kind", "name", "file", "flipped", "emission")
#: Kinds that are films: of a mesh that their values make, or that is read as well.
MADE_KINDS = ("bef", "lens", "composite")
FILM_KINDS = ("film", *MADE_KINDS)


@dataclass(frozen=True)
class Layer:
    """A layer with values of its own, which the stack holds as `name.value`.

    Attributes
    ----------
    name, kind
        unique in the stack; a key of `OWN_VALUES`
    file
        the mesh of a film beside the job's; None: the job's film, or no film
    flipped
        whether a film lies upside down
    """

    name: str
    kind: str
    file: str | None = None
    flipped: bool = False

    @property
    def title(self) -> str:
        """What it is, in words."""
        words = {"film": "film", "bef": "prism film", "plate": "plate", "sheet": "diffuser sheet",
                 "bsdf": "element by its BSDF table", "lens": "lens array",
                 "composite": "composite of bonded films",
                 "reflective_polariser": "reflective polariser",
                 "mueller": "element by its Mueller matrix",
                 "converter": "converting sheet"}  # fmt: skip
        where = f" {Path(self.file).name}" if self.file else ""
        down = ", upside down" if self.flipped else ""
        return f"{words.get(self.kind, self.kind)}{where}{down}"


def read_layer(
    where: str, entry: object, place: int, folder: Path
) -> tuple[str, Layer | None, dict[str, object]]:
    """Return (name, own layer or None, its own values as given) of an entry of `layers`.

    `place` counts from 1; files are beside `folder`.

    Raises
    ------
    InputError
        when the entry is neither a known name nor a table of a known kind.
    """
    if isinstance(entry, str):
        if entry not in LAYERS:
            raise InputError(f"{where}: layers: {entry!r}: expected one of {', '.join(LAYERS)}")
        return entry, None, {}
    if not isinstance(entry, dict) or str(entry.get("kind")) not in OWN_VALUES:
        kinds = ", ".join(OWN_VALUES)
        raise InputError(
            f"{where}: layers: {entry}: expected a name, or a table with a kind of {kinds}"
        )
    kind = entry["kind"]
    name = _own_name(where, entry, place)
    at = f"{where}: layers: {name}"
    if kind == "bsdf":
        return name, Layer(name, kind), {}
    if kind == "mueller":
        entry = _with_entries(at, entry)
    is_film = kind in FILM_KINDS
    allowed = [*_FLAGS[:2], *(("file",) if kind == "film" else ()), *OWN_VALUES[kind]]
    allowed += ["flipped"] if is_film else []
    allowed += ["emission"] if kind == CONVERTER else []
    unknown = sorted(set(entry) - set(allowed))
    if unknown:
        raise InputError(f"{at}: {unknown[0]}: unknown key; expected: {', '.join(allowed)}")
    flipped, file = entry.get("flipped", False), entry.get("file")
    if not isinstance(flipped, bool):
        raise InputError(f"{at}: flipped: {flipped}: expected true or false")
    if file is not None:
        file = str(folder / str(file))
        if not Path(file).is_file():
            raise InputError(f"{at}: file: {file}: no such file: expected a mesh or table")
    values = {key: value for key, value in entry.items() if key not in _FLAGS}
    return name, Layer(name, kind, file, flipped), values


def _with_entries(at: str, entry: dict[str, object]) -> dict[str, object]:
    """Return an entry with the rows of its Mueller matrix as values of their own."""
    matrix = entry.get("matrix")
    rows = matrix if isinstance(matrix, list) else []
    if len(rows) != 4 or not all(isinstance(row, list) and len(row) == 4 for row in rows):
        raise InputError(f"{at}: matrix: {matrix}: expected four rows of four numbers")
    rest = {key: value for key, value in entry.items() if key != "matrix"}
    return {**rest, **dict(zip(MUELLER_ENTRIES, (m for row in rows for m in row), strict=True))}


def _own_name(where: str, entry: dict[str, object], place: int) -> str:
    """Return the checked name of a layer with values of its own."""
    name = entry.get("name", f"{entry['kind']}_{place}")
    at = f"{where}: layers: {name}"
    if not isinstance(name, str) or not re.fullmatch(r"[a-z][a-z0-9_]{0,40}", name):
        raise InputError(f"{at}: name: expected small letters, digits and _, a letter first")
    if name in (*LAYERS, "reflector"):
        raise InputError(f"{at}: name: expected one that no named layer has")
    return name
