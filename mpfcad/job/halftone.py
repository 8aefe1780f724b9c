"""`[halftone]` of a job or a design under LEDs: pieces of grooves, bare or printed alike."""

from typing import Annotated

from pydantic import Field

from mpfcad.job.table import Positive, Table


class HalftoneTable(Table):
    """`[halftone]`: C of a printed piece before it levels, about how long pieces are, how wide.

    `grooves` is how many lie side by side, or one more, and are printed alike.
    """

    curvature_per_mm: Annotated[Positive, Field(le=10_000)]
    piece_mm: Annotated[Positive, Field(le=100)]
    grooves: Annotated[int, Field(ge=1, le=1000)] = 1
