"""Calibrations of the printing process on disk (TOML), and the one that is built in."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from mpfcad.boundary import read_toml, reads
from mpfcad.errors import InputError
from mpfcad.film.groove import Groove
from mpfcad.film.process.model import Process
from mpfcad.film.process.tone import PARAMETERS, ToneBelief
from mpfcad.units import um

Ratio = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Curvature = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
#: The three ways in which a calibration may state what was printed.
RESULTS = ("curvature_per_mm", "fitted_curvature_per_mm", "fill_fraction")

#: The built-in calibration, word for word that of masks/process-thesis.toml.
PUBLISHED: dict[str, Any] = {
    "schema": 1,
    "kind": "volume",
    "source": (
        "Hsieh, MPF thesis: a film printed at 10 % filling ratio had a fitted curvature of 58 /mm "
        "(stylus profiler over two prism widths, parabola fit). Read here as an aperture ratio of "
        "0.10."
    ),
    "caveats": [
        "calibrated to one published pair, so the straight line through it is assumed",
        (
            "the published curvature is a fitted one (54.6 /mm through the tips); read as through "
            "the tips it would give a transfer factor of 0.911; 1 is the model without a free "
            "parameter"
        ),
        (
            "the stylus's tip is not known and makes a groove look emptier: if one of 2 µm radius "
            "was not taken off, the pair means a transfer factor of 1.494, of 5 µm 1.765"
        ),
    ],
    "groove": {"pitch_um": 50.0, "depth_um": 25.0},
    "pair": {"aperture_ratio": 0.10, "fitted_curvature_per_mm": 58.0},
}


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class _Row(_Strict):
    """One print: its aperture ratio and what came of it, stated in exactly one way."""

    aperture_ratio: Ratio
    curvature_per_mm: Curvature | None = None
    fitted_curvature_per_mm: Curvature | None = None
    fill_fraction: Ratio | None = None

    @model_validator(mode="after")
    def _one_result(self) -> "_Row":
        if sum(getattr(self, name) is not None for name in RESULTS) != 1:
            raise ValueError(f"expected exactly one of {', '.join(RESULTS)}")
        return self

    def fill_in(self, groove: Groove) -> float:
        """Return the fill fraction; a ValueError says which value `groove` cannot have."""
        if self.fill_fraction is not None:
            return self.fill_fraction
        curvature = self.curvature_per_mm
        if self.fitted_curvature_per_mm is not None:
            curvature = groove.curvature_of_fitted(self.fitted_curvature_per_mm)
        assert curvature is not None  # exactly one of the three is given
        if curvature > groove.curvature_empty:
            top = groove.curvature_empty
            raise ValueError(f"curvature_per_mm: {curvature:g}: expected 0 … {top:g}")
        return float(groove.fill_fraction(curvature))


class _GrooveSize(_Strict):
    """The groove that the calibration was made in; the BEF of the thesis unless stated."""

    pitch_um: Annotated[float, Field(ge=1, le=2000)] = 50.0
    depth_um: Annotated[float, Field(ge=0.1, le=2000)] = 25.0


class _Tone(_Strict):
    """A tone curve with the deviations and correlations of `PARAMETERS`."""

    transfer_factor: Positive
    dead_zone: Annotated[float, Field(ge=0, lt=0.5, allow_inf_nan=False)]
    contrast: Positive
    gain: Positive
    deviation: Annotated[list[NotNegative], Field(min_length=4, max_length=4)]
    correlation: Annotated[list[list[float]], Field(min_length=4, max_length=4)]

    def belief(self) -> ToneBelief:
        """Return it; a ValueError says what is no covariance."""
        logs = [np.log(self.transfer_factor), self.dead_zone]
        mean = np.array([*logs, np.log(self.contrast), np.log(self.gain)])
        if any(len(row) != len(PARAMETERS) for row in self.correlation):
            raise ValueError("tone.correlation: expected 4 rows of 4")
        matrix = np.array(self.correlation)
        sound = np.allclose(matrix, matrix.T, atol=1e-6) and np.allclose(np.diag(matrix), 1)
        if not (sound and np.linalg.eigvalsh(matrix).min() > -1e-6):
            raise ValueError("tone.correlation: expected 1 on the diagonal and a symmetric matrix")
        return ToneBelief(mean, np.outer(self.deviation, self.deviation) * matrix)


class _Screen(_Strict):
    """The screen that the coupons were printed through."""

    mesh: str | None = None
    volume_cm3_m2: Positive
    solids_fraction: Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)] = 1.0


class _Coupon(_Strict):
    """One print that the tone curve was found from; for the reader, not used again."""

    file: str
    aperture_ratio: Ratio
    fill_fraction: Ratio
    ci95: list[float]


class _Calibration(_Strict):
    schema_: Literal[1] = Field(alias="schema")
    kind: Literal["volume", "table", "tone"]
    source: Annotated[str, Field(min_length=1)]
    caveats: list[str] = []
    groove: _GrooveSize = _GrooveSize()
    transfer_factor: Positive | None = None
    pair: _Row | None = None
    row: list[_Row] | None = None
    tone: _Tone | None = None
    screen: _Screen | None = None
    coupon: list[_Coupon] = []

    @model_validator(mode="after")
    def _fits_kind(self) -> "_Calibration":
        if (self.kind == "tone") != (self.tone is not None):
            raise ValueError("expected [tone] for kind 'tone', and for no other")
        if self.kind == "tone":
            if self.pair or self.transfer_factor or self.row:
                raise ValueError("expected [tone] and neither pair, transfer_factor nor [[row]]")
        elif self.kind == "table":
            if self.pair or self.transfer_factor or len(self.row or []) < 2:
                raise ValueError("expected two or more [[row]] and nothing else for a table")
        elif self.row or (self.pair is None) == (self.transfer_factor is None):
            raise ValueError(
                "expected exactly one of [pair] and transfer_factor for a volume model"
            )
        return self


@reads("a process calibration (TOML)")
def read_process(path: Path | None, groove: Groove) -> Process:
    """Read a calibration; None gives the built-in one, the volume model of the published pair.

    Raises
    ------
    InputError
        one line with file, field or row, value and expected range.
    """
    if path is None:
        return _build_process("built-in process", PUBLISHED, groove)
    path = Path(path)
    return _build_process(str(path), read_toml(path), groove)


def _build_process(where: str, data: dict[str, Any], groove: Groove) -> Process:
    try:
        given = _Calibration.model_validate(data)
    except ValidationError as error:
        raise InputError(f"{where}: {_first_error(error)}") from None
    made_in = Groove(given.groove.pitch_um * um, given.groove.depth_um * um)
    screen = {} if given.screen is None else given.screen.model_dump()
    if given.tone is not None:
        try:
            belief = given.tone.belief().scaled(made_in.depth / groove.depth)
        except ValueError as error:
            raise InputError(f"{where}: {error}") from None
        solids = screen.get("solids_fraction", 1.0)
        return Process.build_tone(
            groove, belief, given.source, tuple(given.caveats), solids_fraction=solids,
            screen=screen,
        )  # fmt: skip
    if given.transfer_factor is not None:
        ratio, fill = np.ones(1), np.array([given.transfer_factor])
    else:
        rows = given.row or ([given.pair] if given.pair else [])
        names = [f"row {i + 1}" for i in range(len(rows))] if given.row else ["pair"]
        ratio = np.array([row.aperture_ratio for row in rows])
        fill = np.array([_fill(where, n, r, made_in) for n, r in zip(names, rows, strict=True)])
        _check_growth(where, names, ratio, fill)
        if given.kind == "volume":
            ratio, fill = np.ones(1), fill / ratio
    fill = fill * (made_in.depth / groove.depth)
    kind: Literal["volume", "table"] = "volume" if given.kind == "volume" else "table"
    process = Process.build(groove, kind, ratio, fill, given.source, tuple(given.caveats))
    return replace(process, screen=screen)


def _fill(where: str, name: str, row: _Row, groove: Groove) -> float:
    try:
        return row.fill_in(groove)
    except ValueError as error:
        raise InputError(f"{where}: {name}: {error}") from None


def _check_growth(where: str, names: list[str], ratio: np.ndarray, fill: np.ndarray) -> None:
    """Refuse rows that do not grow in aperture ratio and in fill alike, from (0, 0) on."""
    before = ("no aperture", 0.0, 0.0)
    for i, (name, a, f) in enumerate(zip(names, ratio, fill, strict=True)):
        if not (i == 0 and len(names) > 1 and a == f == 0):
            if a <= before[1]:
                raise InputError(
                    f"{where}: {name}: aperture_ratio {a:g}: not monotone: expected more than "
                    f"{before[1]:g} of {before[0]}"
                )
            if f <= before[2]:
                raise InputError(
                    f"{where}: {name}: fill_fraction {f:.4g}: not monotone: expected more than "
                    f"{before[2]:.4g} of {before[0]} (more aperture, more fill, less curvature)"
                )
        before = (name, a, f)


def _first_error(error: ValidationError) -> str:
    """Return pydantic's first error as `field: value: what is expected`, on one line."""
    first = error.errors()[0]
    place = [f"row {p + 1}" if isinstance(p, int) else str(p) for p in first["loc"]]
    place = [p for i, p in enumerate(place) if not (p == "row" and i + 1 < len(place))]
    text = " ".join(first["msg"].removeprefix("Value error, ").split())
    if first["type"] == "missing":
        return f"{'.'.join(place)}: missing: expected a value"
    if first["type"] == "extra_forbidden":
        text = "unknown key"
    text = text.replace("Input should be", "expected", 1)
    value = first["input"]
    shown = ", ".join(value) if isinstance(value, dict) else repr(value)
    return ": ".join([*([".".join(place)] if place else []), shown, text])
