"""How thin, how sparse or with how few LEDs: the hardest of a range of boards that still serves.

The model of a board is one trace of an even film in it, with the response that films have by
experience, or one film by a pilot, and the linear programme of `bound` for the best pattern: a few
seconds each. It
proposes a board by bisection; that one's map is searched and traced from files. What a search
reached over what the model said corrects the model for the next proposal. The search ends when
one board serves and the next harder one does not.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mpfcad.backlight import Stack
from mpfcad.errors import InputError
from mpfcad.job.led_design import LedDesign, build_led_design
from mpfcad.pipeline.led.bound import least_contrast
from mpfcad.pipeline.led.search import LedSearch

#: By aim: what the range is of, in words and with its unit.
AIMS = {
    "thinnest": ("thickness", "mm"),
    "sparsest": ("LED pitch", "mm"),
    "fewest": ("LEDs across", ""),
}
_WHOLE = 1e-6
#: Boards that the model proposes.
_BY_MODEL = 2


@dataclass(frozen=True, eq=False)
class Board:
    """One of the range.

    Attributes
    ----------
    value
        thickness or pitch [mm], or number of LEDs across the panel
    design
        the design with such a board
    """

    value: float
    design: LedDesign


def boards_of(design: LedDesign, where: str, panel: tuple[float, float]) -> list[Board]:
    """Return the boards of a design's range, the easiest first.

    `panel` is its size [mm] across and along the grooves.

    Raises
    ------
    InputError
        that begins with `where`, for a pitch that is no whole number of grooves.
    """
    table, aim = design.range, design.goal.aim
    assert table is not None  # the model has looked
    count = math.floor((table.max - table.min) / table.step + _WHOLE) + 1
    values = [float(f"{table.min + k * table.step:.9g}") for k in range(count)]
    if values[-1] < table.max:
        values.append(table.max)
    groove = design.film.groove.pitch
    if aim == "sparsest":
        for value in values:
            if abs(value / groove - round(value / groove)) > _WHOLE:
                raise InputError(
                    f"{where}: range: LED pitch {value:g} mm: expected whole grooves of "
                    f"{groove * 1e3:g} µm"
                )
    harder = values if aim == "sparsest" else values[::-1]
    return [
        Board(value, _with(design, where, _stack(aim, value, groove, panel))) for value in harder
    ]


def _stack(aim: str, value: float, groove: float, panel: tuple[float, float]) -> dict[str, Any]:
    """Return what a board states: `thickness_mm`, or the pitches to override."""
    if aim == "thinnest":
        return {"thickness_mm": value}
    pitch = (value, value)
    if aim == "fewest":
        numbers = value, max(1, round(value * panel[1] / panel[0]))
        pitch = tuple(  # type: ignore[assignment]  # two of them
            float(f"{math.floor(p / n / groove + _WHOLE) * groove:.9g}")
            for p, n in zip(panel, numbers, strict=True)
        )
    return {"override": {"led_pitch_across_mm": pitch[0], "led_pitch_along_mm": pitch[1]}}


def board_words(aim: str, stack: Stack) -> str:
    """Return which board of a range a stack has, in words."""
    if aim == "thinnest":
        return f"thickness {stack.thickness:g} mm"
    cell = stack.source.cell
    return f"cell {cell.across:g} × {cell.along:g} mm"


def _with(design: LedDesign, where: str, stack: dict[str, Any]) -> LedDesign:
    document = design.model_dump(mode="json", by_alias=True, exclude_unset=True)
    own = document["stack"]
    override = {**own.get("override", {}), **stack.get("override", {})}
    document["stack"] = {**own, **stack, **({"override": override} if override else {})}
    return build_led_design(document, where)


@dataclass(eq=False)
class GoalSearch:
    """Finds the hardest board that serves.

    Attributes
    ----------
    boards
        easiest first
    search_of
        returns the search of a board's map
    target
        contrast at which a board serves
    modelled, begun, searched
        by the number of a board: the model's least contrast; its search; those that were run
    """

    boards: list[Board]
    search_of: Callable[[Board], LedSearch]
    target: float
    modelled: dict[int, float] = field(default_factory=dict)
    begun: dict[int, LedSearch] = field(default_factory=dict)
    searched: dict[int, LedSearch] = field(default_factory=dict)

    def run(self) -> int:
        """Return the number of the hardest board that serves; the easiest where none does."""
        serves, fails = -1, len(self.boards)
        while fails - serves > 1:
            chosen = self._proposed(serves, fails)
            search = self._search(chosen)
            search.run()
            self.searched[chosen] = search
            if search.best.found.contrast.value <= self.target:
                serves = chosen
            else:
                fails = chosen
        return max(serves, 0)

    @property
    def serves(self) -> bool:
        """Whether any board that was searched serves."""
        best = (one.best.found.contrast.value for one in self.searched.values())
        return any(value <= self.target for value in best)

    def _search(self, number: int) -> LedSearch:
        if number not in self.begun:
            self.begun[number] = self.search_of(self.boards[number])
        return self.begun[number]

    def _proposed(self, serves: int, fails: int) -> int:
        """Return the hardest board between that the corrected model takes to serve.

        Once it had its chances, the one in the middle.
        """
        if len(self.searched) >= _BY_MODEL:
            return (serves + fails) // 2
        low, high = serves, fails
        while high - low > 1:
            middle = (low + high) // 2
            if self._model(middle) + self._correction() <= self.target:
                low = middle
            else:
                high = middle
        return max(low, serves + 1)

    def _model(self, number: int) -> float:
        if number not in self.modelled:
            search = self._search(number)
            even = search.try_even(search.design.search.uniform_per_mm[-1])
            response = search.response_of(even)
            least = least_contrast(search.design.constraint, even, response)
            self.modelled[number] = least.contrast
        return self.modelled[number]

    def _correction(self) -> float:
        """Return by how much searches missed the model, in the mean."""
        off = [
            search.best.found.contrast.value - self.modelled[number]
            for number, search in self.searched.items()
            if number in self.modelled
        ]
        return float(np.mean(off)) if off else 0.0

    def describe(self, chosen: int, aim: str) -> dict[str, Any]:
        """Return what was found of each board, in plain values."""
        name, unit = AIMS[aim]
        return {
            "aim": aim,
            "of": name,
            "unit": unit,
            "contrast_target": self.target,
            "chosen": self.boards[chosen].value,
            "serves": self.serves,
            "boards": [
                {
                    "value": board.value,
                    "model_least": self.modelled.get(number),
                    "searched": self._searched(number),
                }
                for number, board in enumerate(self.boards)
                if number in self.modelled or number in self.searched
            ],
        }

    def _searched(self, number: int) -> dict[str, Any] | None:
        if number not in self.searched:
            return None
        contrast = self.searched[number].best.found.contrast
        return {
            "value": contrast.value,
            "ci95": [contrast.low, contrast.high],
            "serves": contrast.value <= self.target,
            "traces": len(self.searched[number].tried),
        }
