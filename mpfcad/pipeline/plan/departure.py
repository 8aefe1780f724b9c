"""How films and board of a stack of LEDs depart from the job: registration, resin, binning."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.errors import InputError
from mpfcad.film import Groove, Profile

#: C at all of u by all of v in periods from the LED, (n, m) float64 [1/mm].
CellMap = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
#: Places along each axis that a map's mean is taken over.
_MEAN = 64


@dataclass(frozen=True)
class PrintError:
    """How a printed film departs from its map.

    Attributes
    ----------
    shift
        along the panel's x and y [mm], of the map against the LEDs
    resin
        more resin in every groove, as a share of what it has
    pattern
        more departure of C from its mean, as a share
    curvature
        added to C [1/mm]; where a print's is above bare prisms', they stay bare
    """

    shift: tuple[float, float] = (0.0, 0.0)
    resin: float = 0.0
    pattern: float = 0.0
    curvature: float = 0.0

    def on(
        self, at: CellMap, cell: tuple[float, float], groove: Groove, profile: Profile
    ) -> CellMap:
        """Return a map over a cell [mm] as it is printed, or moulded."""
        if self == AS_MAPPED:
            return at
        across, along = (move / size for move, size in zip(self.shift, cell, strict=True))
        place = np.arange(_MEAN) / _MEAN
        mean = float(at(place, place).mean())
        most = groove.curvature_empty if profile == "filled" else math.inf

        def printed(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
            found = np.mod(u - across, 1.0), np.mod(v - along, 1.0)
            c = mean + (1 + self.pattern) * (at(*found) - mean) + self.curvature
            c = np.minimum(c, most)
            if self.resin:
                fill = np.asarray(groove.fill_fraction(np.maximum(c, 0.0)))
                c = np.asarray(groove.curvature_of_fill(fill * (1 + self.resin)))
            return c

        return printed


AS_MAPPED = PrintError()


@dataclass(frozen=True)
class Departure:
    """How a panel of LEDs departs from its job.

    Attributes
    ----------
    films
        of each printed film, the first one's first; none: as the job has them
    repeat, seed, dead
        of the board, in place of its own: cells traced together along x and y, seed of the draws
        of flux and place, numbers of LEDs that do not shine
    """

    films: tuple[PrintError, ...] = field(default=())
    repeat: tuple[int, int] | None = None
    seed: int | None = None
    dead: tuple[int, ...] | None = None

    def film(self, number: int) -> PrintError:
        """Return how a film departs, by its number from 0."""
        return self.films[number] if number < len(self.films) else AS_MAPPED

    def of_map(self, number: int, *, halftone: bool) -> PrintError:
        """Return how a film's map departs: of a halftone's, its pattern; its pieces do the rest."""
        film = self.film(number)
        return PrintError(pattern=film.pattern) if halftone else film

    def of_board(self, stack: Stack, where: str) -> Stack:
        """Return a stack with the board as it is.

        Raises
        ------
        InputError
            that begins with `where`, when the LEDs do not fit so.
        """
        from mpfcad.backlight.source import LedSpec

        if self.repeat is self.seed is self.dead is None:
            return stack
        spec = stack.spec
        if not isinstance(spec, LedSpec):
            raise InputError(f"{where}: stack {stack.name}: tubes light it: expected LEDs")
        board = replace(
            spec,
            repeat=spec.repeat if self.repeat is None else self.repeat,
            seed=spec.seed if self.seed is None else self.seed,
            dead=spec.dead if self.dead is None else self.dead,
        )
        changed = replace(stack, spec=board)
        changed.source.check(where)
        return changed


AS_DESIGNED = Departure()
