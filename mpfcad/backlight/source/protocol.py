"""What every kind of light source tells the rest of the program."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

if TYPE_CHECKING:
    from mpfcad.optics.element import Element

Range = tuple[float, float]


class Period(NamedTuple):
    """The size [mm] of what repeats sideways; `along` is 0 where nothing changes along y."""

    across: float
    along: float


class Emitters(NamedTuple):
    """How a source is drawn in the stack's cross-section.

    Attributes
    ----------
    name, note
        in words: what it is; its numbers
    width, height
        of one emitter's cross-section [mm]
    centre
        height [mm] of its middle over the reflector
    is_round
        whether the cross-section is a circle; else a rectangle
    spacing
        of the emitters [mm]
    """

    name: str
    note: str
    width: float
    height: float
    centre: float
    is_round: bool
    spacing: float


class StackValues(Protocol):
    """What a source reads of its stack."""

    @property
    def quantity(self) -> Mapping[str, Any]:
        """Every number by its name."""

    @property
    def extent(self) -> str:
        """`pitch` or `panel`."""

    def __getitem__(self, name: str) -> float:
        """Return a value in the unit of its name."""


class LightSource(Protocol):
    """A kind of light source in a stack.

    Attributes
    ----------
    word
        what one emitter is called
    """

    word: ClassVar[str]

    @property
    def period(self) -> Period:
        """What repeats sideways without end."""

    @property
    def cell(self) -> Period:
        """What repeats as designed: a map's period; `period` may hold several, which differ."""

    @property
    def origin(self) -> tuple[float, float]:
        """(x, y) on the panel [mm] of the scene's x = 0, y = 0."""

    @property
    def count(self) -> int:
        """Emitters on the panel."""

    @property
    def flux(self) -> float:
        """Flux [lm] of all emitters on the panel."""

    @property
    def lit_size(self) -> Period:
        """Size [mm] of what they light, about the panel's middle."""

    @property
    def lit_area(self) -> float:
        """Area [m²] that they light."""

    def check(self, where: str) -> None:
        """Raise `InputError` unless the emitters fit the stack."""

    def lower(self, tables: Mapping[str, Any]) -> "Element":
        """Return the lowest element of the scene; `tables` may hold a BRDF as `reflector`."""

    def emitters(self) -> Emitters:
        """Return how the source is drawn."""


class SourceSpec(Protocol):
    """What a stack file's `[source]` says: the kind, and what is no number.

    Attributes
    ----------
    ranges, panel_ranges
        values that such a stack must have; on a finite panel besides: lowest and highest
    defaults
        value that a missing one of `panel_ranges` takes, by the name of another
    optional
        values that may be left out: their range, and the number or the name of the value that they
        then have
    """

    kind: ClassVar[str]
    optional: ClassVar[Mapping[str, tuple[Range, str | float]]]
    ranges: ClassVar[Mapping[str, Range]]
    panel_ranges: ClassVar[Mapping[str, Range]]
    defaults: ClassVar[Mapping[str, str]]

    @classmethod
    def read(cls, where: str, folder: Path, entry: Mapping[str, Any]) -> "SourceSpec":
        """Return the spec of a stack file's `[source]`, its files beside `folder`."""

    @classmethod
    def restore(cls, document: Mapping[str, Any]) -> "SourceSpec":
        """Return the spec that `describe` has described."""

    def find_range(self, key: str) -> Range | None:
        """Return the range of another value that a source may have; None for no such value."""

    def numbered(self, keys: Mapping[str, Any]) -> list[str]:
        """Return the names among `keys` of such values, in order."""

    def patterns(self) -> list[str]:
        """Return how such names are made, for messages."""

    def inputs(self) -> list[dict[str, Any]]:
        """Return what is no number as {name, value, tag, source}."""

    def describe(self) -> dict[str, Any]:
        """Return the spec as plain values, empty for the default; `restore_spec` reads them."""

    def of(self, stack: StackValues) -> LightSource:
        """Return the source with a stack's values."""
