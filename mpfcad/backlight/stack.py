"""A backlight: its layers from the lamps up and every number it hangs on, each with its source."""

import math
from dataclasses import dataclass, replace
from typing import Literal

from mpfcad.backlight.bsdf_layer import BsdfLayer
from mpfcad.errors import InputError
from mpfcad.optics.mesh import FilmMesh
from mpfcad.optics.scene import BsdfSheet, Cavity, Element, Film, Sheet, Slab

Tag = Literal["given", "sourced", "assumed"]

#: What a layer may be, with what it is in words.
LAYERS = {
    "clear_plate": "clear plate",
    "diffusing_plate": "diffusing plate",
    "bottom_sheet": "bottom diffuser sheet",
    "film": "film",
    "bonded_film": "film bonded on the plate",
    "top_sheet": "top diffuser sheet",
    "bsdf": "element by its BSDF table",
}

_TINY = 1e-6
#: Every value of a stack and its allowed range, in the unit of its name.
RANGES = {
    "panel_width_mm": (1.0, 10_000.0),
    "panel_length_mm": (1.0, 10_000.0),
    "lamp_count": (1, 10_000),
    "lamp_pitch_mm": (0.1, 1000.0),
    "lamp_radius_mm": (0.01, 100.0),
    "lamp_height_mm": (0.01, 1000.0),
    "lamp_reflectance": (0.0, 1.0),
    "lamp_luminance_cd_m2": (_TINY, 1e9),
    "thickness_mm": (0.1, 1000.0),
    "reflector_reflectance": (0.0, 1.0),
    "reflector_specular_fraction": (0.0, 1.0),
    "plate_index": (1.0, 4.0),
    "plate_thickness_mm": (0.01, 100.0),
    "plate_scattering_per_mm": (0.0, 100.0),
    "plate_asymmetry": (-0.99, 0.99),
    "plate_absorption_per_mm": (0.0, 100.0),
    "bottom_sheet_sigma": (0.0, 10.0),
    "top_sheet_sigma": (0.0, 10.0),
    "sheet_index": (1.0, 4.0),
    "sheet_transmission": (0.0, 1.0),
    "film_index": (1.0, 4.0),
    "meter_acceptance_deg": (0.0, 45.0),
    "meter_spot_mm": (0.0, 1000.0),
}


@dataclass(frozen=True)
class Quantity:
    """A number with where it comes from."""

    value: float
    tag: Tag
    source: str


@dataclass(frozen=True)
class Stack:
    """A backlight stack; `quantity` holds every number under its name with unit suffix.

    Attributes
    ----------
    name, title
        the preset's or file's name; one line in words
    layers
        from the lamps up, names of `LAYERS`; one is a film, or none where one is a table
    quantity
        one entry for each name of `RANGES`
    tables
        the tables of the `bsdf` layers, in their order
    reflector
        a table in the place of the reflector's two values
    """

    name: str
    title: str
    layers: tuple[str, ...]
    quantity: dict[str, Quantity]
    tables: tuple[BsdfLayer, ...] = ()
    reflector: BsdfLayer | None = None

    def __getitem__(self, name: str) -> float:
        """Return a value in the unit of its name."""
        return self.quantity[name].value

    @property
    def panel_width(self) -> float:
        """Extent across the lamps [mm]."""
        return self["panel_width_mm"]

    @property
    def panel_length(self) -> float:
        """Extent along the lamps [mm]."""
        return self["panel_length_mm"]

    @property
    def thickness(self) -> float:
        """From the reflector to the lowest layer [mm]."""
        return self["thickness_mm"]

    @property
    def lamp_count(self) -> int:
        """Number of lamps."""
        return int(self["lamp_count"])

    @property
    def lamp_pitch(self) -> float:
        """Spacing of the lamps [mm]."""
        return self["lamp_pitch_mm"]

    def lamp_position(self, number: int) -> float:
        """Return the axis' position [mm] on the panel of lamp `number`, from 0 at the left."""
        row = (self.lamp_count - 1) * self.lamp_pitch
        return (self.panel_width - row) / 2 + number * self.lamp_pitch

    def with_values(self, values: dict[str, Quantity]) -> "Stack":
        """Return the stack with some quantities replaced."""
        return replace(self, quantity={**self.quantity, **values})

    def inputs(self) -> list[dict[str, object]]:
        """Return each input as {name, value, tag, source}: numbers as in `RANGES`, then tables."""
        numbers = [
            {"name": k, "value": q.value, "tag": q.tag, "source": q.source}
            for k, q in ((k, self.quantity[k]) for k in RANGES)
        ]
        named = [(f"bsdf.{i}", layer) for i, layer in enumerate(self.tables, 1)]
        if self.reflector is not None:
            named.append(("reflector", self.reflector))
        return numbers + [
            {
                "name": name,
                "value": layer.name,
                "tag": layer.tag,
                "source": "; ".join((f"{layer.source}, SHA-256 {layer.sha256}", *layer.table.note)),
            }
            for name, layer in named
        ]

    @property
    def has_film(self) -> bool:
        """Whether the stack has a slot for a film mesh."""
        return any(layer.endswith("film") for layer in self.layers)

    def elements(self, mesh: FilmMesh | None, offset: float = 0.0) -> list[Element]:
        """Return the traced elements from the bottom up; x = 0 is a lamp's axis.

        `offset` [mm] is the x of the film tile's left edge.

        Raises
        ------
        InputError
            when there is a mesh and no film in the stack, or a film and no mesh.
        """
        if self.has_film != (mesh is not None):
            what = "its film needs a mesh" if self.has_film else "has no film: allowed is no mesh"
            raise InputError(f"stack {self.name}: {what}")
        tables = iter(self.tables)
        bonded = "bonded_film" in self.layers
        elements: list[Element] = [self._cavity()]
        for layer in self.layers:
            match layer:
                case "clear_plate" | "diffusing_plate":
                    elements.append(self._plate(layer == "diffusing_plate", bonded))
                case "bottom_sheet" | "top_sheet":
                    elements.append(self._sheet(layer))
                case "bsdf":
                    layer = next(tables)
                    elements.append(BsdfSheet(layer.table, layer.blend, layer.name))
                case _:
                    below = self["plate_index"] if bonded else 1.0
                    elements.append(Film(mesh, self["film_index"], below, offset))
        return elements

    def _cavity(self) -> Cavity:
        return Cavity(
            height=self.thickness,
            lamp_pitch=self.lamp_pitch,
            lamp_position=0.0,
            lamp_height=self["lamp_height_mm"],
            lamp_radius=self["lamp_radius_mm"],
            lamp_luminance=self["lamp_luminance_cd_m2"],
            lamp_reflectance=self["lamp_reflectance"],
            reflectance=self["reflector_reflectance"],
            specular_fraction=self["reflector_specular_fraction"],
            name="reflector",
            brdf=self.reflector.table if self.reflector else None,
            blend=self.reflector.blend if self.reflector else 1.0,
        )

    def _plate(self, diffusing: bool, bonded: bool) -> Slab:
        volume = {}
        if diffusing:
            volume = {
                "scattering": self["plate_scattering_per_mm"],
                "absorption": self["plate_absorption_per_mm"],
                "asymmetry": self["plate_asymmetry"],
            }
        return Slab(self["plate_index"], self["plate_thickness_mm"], bonded=bonded, **volume)

    def _sheet(self, layer: str) -> Sheet:
        name = layer.replace("_", " ")
        return Sheet(self[f"{layer}_sigma"], self["sheet_index"], self["sheet_transmission"], name)

    @property
    def acceptance(self) -> float:
        """Sine of the meter's half angle."""
        return math.sin(math.radians(self["meter_acceptance_deg"]))
