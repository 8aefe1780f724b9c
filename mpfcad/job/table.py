"""What every table of a job has in common."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from mpfcad.units import from_suffix

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Table(BaseModel):
    """A table of the job: frozen, strict, no unknown key; `pitch` is `pitch_um` in inside units."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, populate_by_name=True)

    def _inside(self, field: str) -> float:
        return from_suffix(field, getattr(self, field))
