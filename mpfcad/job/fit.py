"""The tables of a fit: a backlight with priors, films in it, and what was measured of them."""

from math import inf
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from mpfcad.job.design import Name
from mpfcad.job.model import StackTable, TraceTable
from mpfcad.job.reader import read_document, validate
from mpfcad.job.table import Positive, Table

#: Scalars that a meter states, and what is read from a file.
Scalar = Literal["contrast", "luminance", "fwhm_across_deg", "fwhm_along_deg", "flux", "efficiency"]
Of = Literal[
    "contrast", "luminance", "fwhm_across_deg", "fwhm_along_deg", "flux", "efficiency",
    "curve", "cut_across", "cut_along",
]  # fmt: skip
FILES = ("curve", "cut_across", "cut_along")
#: Least and largest of figures that are not just above 0.
_RANGE = {
    "contrast": (0.0, 1.0), "efficiency": (0.0, 1.0),
    "fwhm_across_deg": (0.0, 180.0), "fwhm_along_deg": (0.0, 180.0),
}  # fmt: skip
_LIMITS = ("value", "at_most", "at_least")
_IMAGE = ("pixel_mm", "cd_m2_per_count", "dark", "flat", "crop", "rotation_deg")
_CURVE = ("lamp_at_mm", "pitch_mm", "unit", "scale_sigma", *_IMAGE)
#: Figures and their errors lie within so much: squares and ratios of more are no numbers.
_MOST = 1e12
Number = Annotated[float, Field(ge=-_MOST, le=_MOST, allow_inf_nan=False)]
Sigma = Annotated[Positive, Field(ge=1 / _MOST, le=_MOST)]


class CaseTable(Table):
    """`[case.NAME]`: a film in the backlight. Without film or curvature it is a plain BEF."""

    layers: list[str] | None = None
    thickness_mm: Annotated[Positive, Field(le=1000)] | None = None
    override: dict[str, Any] = Field(default_factory=dict)
    film: str | None = None
    offset_mm: Number = 0.0
    curvature_per_mm: Annotated[float, Field(ge=0, le=10_000)] | None = None
    profile: Literal["filled", "ideal"] = "filled"
    pitch_um: Annotated[Positive, Field(le=2000)] = 50.0
    depth_um: Annotated[Positive, Field(le=2000)] = 25.0
    base_um: Annotated[Positive, Field(le=5000)] = 200.0

    @model_validator(mode="after")
    def _one_film(self) -> "CaseTable":
        if self.film is not None and self.curvature_per_mm is not None:
            raise ValueError("expected either film or curvature_per_mm")
        return self


class PredictTable(Table):
    """`[[predict]]`: a figure that the fitted backlight is asked for."""

    case: str
    of: Scalar
    over: str | None = None
    name: str | None = None

    @property
    def title(self) -> str:
        """Its name, or what it is."""
        over = f" over {self.over}" if self.over else ""
        return self.name or f"{self.case}{over}: {self.of}"


class CandidateTable(PredictTable):
    """`[[candidate]]`: what could be measured next, with the error that it would have."""

    sigma: Sigma


class MeasurementTable(Table):
    """`[[measurement]]`: a measured figure, curve, image or cut, with its standard error."""

    case: str
    of: Of
    over: str | None = None
    name: str | None = None
    value: Number | None = None
    at_most: Number | None = None
    at_least: Number | None = None
    sigma: Sigma | None = None
    file: str | None = None
    unit: str | None = None
    lamp_at_mm: Number | None = None
    pitch_mm: Positive | None = None
    scale_sigma: Sigma | None = None
    pixel_mm: Positive | None = None
    cd_m2_per_count: Positive = 1.0
    dark: str | None = None
    flat: str | None = None
    crop: Annotated[tuple[int, int, int, int], Field(strict=False)] | None = None
    rotation_deg: Number = 0.0

    @property
    def title(self) -> str:
        """Its name, or what it is."""
        over = f" over {self.over}" if self.over else ""
        return self.name or f"{self.case}{over}: {self.of}"

    @model_validator(mode="after")
    def _complete(self) -> "MeasurementTable":
        stated = [key for key in _LIMITS if getattr(self, key) is not None]
        if self.of in FILES:
            if stated or self.over is not None:
                raise ValueError(
                    f'of = "{self.of}": expected file, and no {", ".join(_LIMITS)}, over'
                )
            if self.file is None:
                raise ValueError(
                    f'of = "{self.of}": file: missing: expected a file beside this one'
                )
            if self.of == "curve" and self.lamp_at_mm is None:
                raise ValueError(
                    "lamp_at_mm: missing: expected a lamp's place in the curve, which does not "
                    "tell whether lamps are bright or dark in it"
                )
        else:
            if len(stated) != 1 or self.file is not None:
                raise ValueError(f'of = "{self.of}": expected one of {", ".join(_LIMITS)}')
            if self.sigma is None:
                raise ValueError("sigma: expected the standard error, above 0")
            self._check_possible(stated[0])
        wrong = sorted(self.model_fields_set & set(_CURVE)) if self.of != "curve" else []
        if wrong:
            raise ValueError(f'{wrong[0]}: expected only with of = "curve"')
        return self

    def _check_possible(self, key: str) -> None:
        value = getattr(self, key)
        low, high = _RANGE.get(self.of, (0.0, inf)) if self.over is None else (0.0, inf)
        if not low <= value <= high or (high == inf and value == 0):
            what = self.of if self.over is None else f"{self.of} over {self.over}"
            wanted = "a value above 0" if high == inf else f"{low:g} … {high:g}"
            raise ValueError(f"{key}: {value:g}: {what}: expected {wanted}")


class Fit(Table):
    """A whole fit."""

    version: Literal[1] = Field(default=1, alias="schema")
    name: Name
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1
    stack: StackTable = StackTable(preset="thesis-32in-mpf")
    values: Annotated[list[str], Field(min_length=1)] | None = None
    free: list[str] = Field(default_factory=list)
    covariance: str | None = None
    trace: TraceTable = TraceTable()
    case: Annotated[dict[str, CaseTable], Field(min_length=1)]
    measurement: Annotated[list[MeasurementTable], Field(min_length=1)]
    candidate: list[CandidateTable] = Field(default_factory=list)
    predict: list[PredictTable] = Field(default_factory=list)

    @model_validator(mode="after")
    def _each_once(self) -> "Fit":
        for field, names in (("values", self.values or []), ("free", self.free)):
            twice = [name for name in names if names.count(name) > 1]
            if twice:
                raise ValueError(f"{field}: {twice[0]}: named twice: expected each value once")
        return self

    @model_validator(mode="after")
    def _known_cases(self) -> "Fit":
        rows: list[tuple[str, Any]] = [("measurement", self.measurement)]
        rows += [("candidate", self.candidate), ("predict", self.predict)]
        for table, entries in rows:
            for number, entry in enumerate(entries, 1):
                if entry.over == entry.case:
                    raise ValueError(
                        f"{table} {number}: over: {entry.over}: is its own case, so the ratio is "
                        "always 1: expected another"
                    )
                for key in ("case", "over"):
                    name = getattr(entry, key)
                    if name is not None and name not in self.case:
                        raise ValueError(
                            f"{table} {number}: {key}: {name}: no such case: expected one of "
                            f"{', '.join(self.case)}, or a table [case.{name}] that describes it"
                        )
        return self

    def document(self) -> dict[str, Any]:
        """Return the fit as plain JSON values, as it is given."""
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True)


def read_fit(path: Path) -> Fit:
    """Return the fit in the TOML file at `path`.

    Raises
    ------
    InputError
        when the file cannot be read, is no TOML (naming the line), or a field is wrong.
    """
    return validate(Fit, read_document(path), str(path))
