"""A backlight: its layers from the lamps up and every number it hangs on, each with its source."""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from mpfcad.backlight.dispersion import DEFAULT_WAVELENGTH_NM
from mpfcad.backlight.layer.bsdf import BsdfLayer
from mpfcad.backlight.layer.stated import CONVERTER, FILM_KINDS, LAYERS, Layer
from mpfcad.backlight.light import light_inputs
from mpfcad.backlight.quantity import (
    FILM_RANGES,
    LIGHT_RANGES,
    PANEL_RANGES,
    PARTICLE_RANGES,
    Quantity,
    ranges_with,
)
from mpfcad.backlight.source import LightSource, Period, SourceSpec, TubeSpec
from mpfcad.spectrum import Bands, weighs_only

#: One lamp pitch that repeats without end, or the whole panel with its walls.
Extent = Literal["pitch", "panel"]
EXTENTS: tuple[Extent, ...] = ("pitch", "panel")
#: Of a stack that states none, to stand for the wavelengths of its bands.
_WAVELENGTH = Quantity(DEFAULT_WAVELENGTH_NM, "assumed", "where none is stated")
#: The film without resin, in an export.
PRISM_FILE = "prism.stl"


@dataclass(frozen=True)
class Stack:
    """A backlight stack; `quantity` holds every number under its name with unit suffix.

    Attributes
    ----------
    name, title
        the preset's or file's name; one line in words
    layers
        from the lamps up, names of `LAYERS` or of `own`; one is the place of the job's
        film, or none where a table stands in it
    quantity
        one entry for each name of `ranges_with`, and those that the stack needs besides
    extent
        `pitch`: everything repeats sideways without end; `panel`: the whole panel with its walls
    own
        by name, the layers with values of their own, which `quantity` holds as `name.value`
    tables
        by the layer's name, BSDF tables; `reflector`: one in the place of the reflector's values
    prism
        mesh file of the job's film without resin: needed where light sees its surface under it
    spec
        the kind of light source, and what of it is no number
    polarised
        whether light is traced with Stokes vectors
    bands
        the wavelengths at which light is traced, if it is at more than one
    """

    name: str
    title: str
    layers: tuple[str, ...]
    quantity: dict[str, Quantity]
    extent: Extent = "pitch"
    own: dict[str, Layer] = field(default_factory=dict)
    tables: dict[str, BsdfLayer] = field(default_factory=dict)
    prism: Path | None = None
    spec: SourceSpec = field(default_factory=TubeSpec)
    polarised: bool = False
    bands: Bands | None = None

    def __getitem__(self, name: str) -> float:
        """Return a value in the unit of its name."""
        return self.quantity[name].value

    def get(self, name: str, default: float = 0.0) -> float:
        """Return a value in the unit of its name, or another number where there is none."""
        return self[name] if name in self.quantity else default

    def of_film(self, key: str) -> float:
        """Return `index`, `absorption_per_mm` or `roughness` of the job's film's prisms."""
        slot = self.slot
        return self.get(f"{slot}.{key}" if slot in self.own else f"film_{key}")

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
    def source(self) -> LightSource:
        """What lights the stack."""
        return self.spec.of(self)

    @property
    def period(self) -> Period:
        """The size [mm] of what repeats sideways."""
        return self.source.period

    @property
    def origin(self) -> tuple[float, float]:
        """(x, y) on the panel [mm] of the scene's x = 0, y = 0."""
        return self.source.origin

    @property
    def acceptance(self) -> float:
        """Sine of the meter's half angle."""
        return math.sin(math.radians(self["meter_acceptance_deg"]))

    @property
    def resin_scatters(self) -> bool:
        """Whether the film's fill holds particles."""
        return "resin_scattering_per_mm" in self.quantity and self["resin_scattering_per_mm"] > 0

    @property
    def resin_differs(self) -> bool:
        """Whether the film's fill has another index or absorption than its prisms, at any band."""
        slot = self.slot
        own = f"{slot}." if slot in self.own else "film_"
        keys = [k for k in ("index", "absorption_per_mm") if f"resin_{k}" in self.quantity]
        at_bands = {} if self.bands is None else self.bands.value
        return any(
            self[f"resin_{key}"] != self.of_film(key)
            or at_bands.get(f"resin_{key}") != at_bands.get(f"{own}{key}")
            for key in keys
        )

    @property
    def needs_prism(self) -> bool:
        """Whether light sees where the resin ends and the prisms begin."""
        if not self.has_slot:
            return False
        return self.resin_scatters or self.resin_differs or self.of_film("roughness") > 0

    @property
    def sheet_count(self) -> int:
        """Number of layers that are handled on their own: a film bonded on a plate is not."""
        return sum(layer != "bonded_film" for layer in self.layers)

    def kind_of(self, layer: str) -> str:
        """Return `plate`, `sheet`, `film` or `bsdf`."""
        kind = self.own[layer].kind if layer in self.own else layer.rpartition("_")[2]
        return "film" if kind in FILM_KINDS else kind

    def title_of(self, layer: str) -> str:
        """Return what a layer is, in words."""
        return self.own[layer].title if layer in self.own else LAYERS[layer]

    def is_slot(self, layer: str) -> bool:
        """Return whether a layer is the place of the job's film."""
        if layer in self.own:
            return self.own[layer].kind == "film" and self.own[layer].file is None
        return layer.endswith("film")

    @property
    def slot(self) -> str | None:
        """The layer that is the place of the job's film."""
        return next(filter(self.is_slot, self.layers), None)

    @property
    def has_slot(self) -> bool:
        """Whether there is a place for the job's film."""
        return self.slot is not None

    @property
    def table_layers(self) -> list[str]:
        """Names of the layers that are BSDF tables."""
        return [layer for layer in self.layers if layer in self.tables]

    @property
    def converters(self) -> list[str]:
        """Names of the layers that convert light from one wavelength to others."""
        return [name for name in self.layers if self.kind_of(name) == CONVERTER]

    def files(self) -> dict[str, Path]:
        """Return the meshes of films beside the job's, by the layer's name."""
        return {name: Path(layer.file) for name, layer in self.own.items() if layer.file}

    def with_files_in(self, folder: Path) -> "Stack":
        """Return the stack with the meshes that it needs besides the film's in a folder."""
        own = {
            name: replace(layer, file=str(Path(folder) / stack_file(name))) if layer.file else layer
            for name, layer in self.own.items()
        }
        return replace(self, own=own).with_prism(Path(folder) / PRISM_FILE)

    def with_prism(self, prism: Path | None) -> "Stack":
        """Return the stack with the mesh file of the film without resin."""
        return replace(self, prism=prism)

    def with_bare(self, mesh: Path) -> "Stack":
        """Return the stack for a film whose grooves are empty: its mesh is that of its prisms."""
        kept = {k: q for k, q in self.quantity.items() if not k.startswith("resin_")}
        bare = replace(self, quantity=kept)
        return bare.with_prism(mesh) if bare.needs_prism else bare

    def with_values(self, values: dict[str, Quantity]) -> "Stack":
        """Return the stack with some quantities replaced.

        One that is not the same at all bands changes there by the same factor.
        """
        bands = self.bands
        if bands is not None and set(values) & set(bands.value):
            kept = dict(bands.value)
            for key in set(values) & set(kept):
                old, found = self[key], kept.pop(key)
                if old > 0:
                    kept[key] = tuple(one * values[key].value / old for one in found)
            bands = replace(bands, value=kept)
        return replace(self, quantity={**self.quantity, **values}, bands=bands)

    def at_band(self, number: int) -> "Stack":
        """Return the stack at the wavelength of one of its bands, which it keeps."""
        bands = self.bands
        if bands is None:
            return self
        at = {key: found[number] for key, found in bands.value.items()}
        quantity = {**self.quantity}
        if bands.separate:
            at["light_wavelength_nm"] = bands.wavelength[number]
            quantity.setdefault("light_wavelength_nm", _WAVELENGTH)
        for key, value in at.items():
            quantity[key] = replace(quantity[key], value=value)
        return replace(self, quantity=quantity)

    def inputs(self) -> list[dict[str, object]]:
        """Return each number in use as {name, value, tag, source}, the usual ones first."""
        panel = self.extent == "panel"
        names = [*ranges_with(self.spec)]
        names += [*self.spec.panel_ranges, *PANEL_RANGES] if panel else []
        names += self.spec.numbered(self.quantity)
        names += [k for k in (*PARTICLE_RANGES, *FILM_RANGES, *LIGHT_RANGES) if k in self.quantity]
        names += [k for layer in self.own for k in self.quantity if k.startswith(f"{layer}.")]
        numbers = [
            {"name": k, "value": q.value, "tag": q.tag, "source": q.source}
            for k, q in ((k, self.quantity[k]) for k in names)
        ]
        tables = [{"name": k, **table.describe_source()} for k, table in self.tables.items()]
        return [*numbers, *self.spec.inputs(), *tables, *self._light()]

    def _flat(self) -> list[str]:
        """Return the values in use that could differ at the bands and do not."""
        if self.bands is None:
            return []
        return [
            key for key, found in self.quantity.items()
            if key not in self.bands.value and found.value > 0 and weighs_only(key)
        ]  # fmt: skip

    def _light(self) -> list[dict[str, object]]:
        """Return how light is traced, where it is not as in the thesis."""
        said = "Stokes vectors along the path"
        light: dict[str, object] = {"name": "light.polarised", "value": "true", "tag": "given"}
        stated = [light | {"source": said}] if self.polarised else []
        return [*stated, *light_inputs(self.bands, self._flat())]


def stack_file(layer: str) -> str:
    """Return the file name in an export of the mesh of a layer."""
    return f"stack-{layer}.stl"
