"""A job as an object: what `mpfcad run`, `mask`, `cad` and `measure` do with a job file."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mpfcad.api.progress import watched
from mpfcad.api.result import Export, Measurement, Run
from mpfcad.api.source import Sourced

if TYPE_CHECKING:
    from mpfcad.job import Job as Model
    from mpfcad.pipeline import Progress


class Job(Sourced["Model"]):
    """A film to make and to verify.

    Parameters
    ----------
    source
        path of a job's TOML file, or its tables as a dict (docs/job.md)
    folder
        where a dict's file names are taken from (None: the working folder)

    Raises
    ------
    InputError
        naming the first field that is wrong, its value and what is expected.

    Examples
    --------
    >>> job = Job({"name": "c60", "map": {"curvature_per_mm": 60.0}})
    >>> job.name
    'c60'
    """

    @staticmethod
    def _model_class() -> "type[Model]":
        from mpfcad.job import Job as Model

        return Model

    @classmethod
    def of_curvature(
        cls,
        curvature_per_mm: ArrayLike,
        position_mm: ArrayLike | None = None,
        *,
        name: str = "film",
        tables: Mapping[str, Mapping[str, Any]] | None = None,
        extent: str = "pitch",
        repeat: str = "repeat",
        folder: str | Path | None = None,
    ) -> "Job":
        """Return the job of a uniform film, or of a map over positions.

        Parameters
        ----------
        curvature_per_mm
            C through the tips [1/mm]: one number, or (m,) float64
        position_mm
            (m,) float64 [mm], increasing, from a lamp's axis (`extent` pitch) or the panel's left
            edge (panel)
        name
            of the job
        tables
            the job's other tables; keys of `map` go before `extent` and `repeat`
        extent, repeat
            what the map spans, as in `[map]` (docs/job.md)
        folder
            where file names in `tables` are taken from

        Raises
        ------
        InputError
            when a value is wrong.
        ValueError
            when the two arrays do not have the same shape.

        Examples
        --------
        >>> import numpy as np
        >>> x = np.linspace(0.0, 32.69, 9)
        >>> Job.of_curvature(60 + 2 * np.cos(2 * np.pi * x / 32.69), x, name="wave").name
        'wave'
        """
        curvature = np.asarray(curvature_per_mm, float)
        mapped: dict[str, Any] = {"curvature_per_mm": float(curvature.flat[0])}
        if curvature.ndim:
            position = np.asarray(position_mm, float)
            if position.shape != curvature.shape or curvature.ndim != 1:
                raise ValueError(
                    f"position_mm has the shape {position.shape}, curvature_per_mm "
                    f"{curvature.shape}: expected the same, (m,)"
                )
            rows = np.stack([position, curvature], axis=1).tolist()
            mapped = {"rows": rows, "extent": extent, "repeat": repeat}
        mapped |= (tables or {}).get("map", {})
        return cls({**(tables or {}), "name": name, "map": mapped}, folder=folder)

    def run(
        self,
        out: str | Path | None = None,
        *,
        effort: str | None = None,
        threads: int | None = None,
        progress: "bool | Progress" = False,
    ) -> Run:
        """Make mask and CAD files, trace the exported film, and return verdict and figures.

        Raises
        ------
        InputError
            when the job or a file it names is wrong; `out` is then as it was.
        """
        from mpfcad.pipeline import default_out, run_job

        folder = Path(out) if out is not None else default_out(self.model)
        with watched(progress) as told:
            record = run_job(
                self.model, self.file, folder, effort=effort, threads=threads, progress=told
            )
        return Run(record, folder)

    def mask(
        self,
        out: str | Path | None = None,
        *,
        formats: Sequence[str] | None = None,
        progress: "bool | Progress" = False,
    ) -> Export:
        """Make and check the mask files only; `formats` None: those the job names."""
        from mpfcad.pipeline import default_out, make_mask

        folder = Path(out) if out is not None else default_out(self.model)
        with watched(progress) as told:
            chosen = None if formats is None else tuple(formats)
            make_mask(self.model, self.file, folder, chosen, told)
        return Export(folder)

    def cad(
        self,
        out: str | Path | None = None,
        *,
        formats: Sequence[str] = ("step", "stl"),
        progress: "bool | Progress" = False,
    ) -> Export:
        """Make and check the CAD files only."""
        from mpfcad.pipeline import default_out, make_cad

        folder = Path(out) if out is not None else default_out(self.model)
        with watched(progress) as told:
            make_cad(self.model, self.file, folder, tuple(formats), told)
        return Export(folder)

    def measure(
        self,
        what: Sequence[str] | None = None,
        out: str | Path | None = None,
        *,
        seed: int = 1,
        effort: str = "standard",
        threads: int | None = None,
        progress: "bool | Progress" = False,
    ) -> Measurement:
        """Return photometric figures of the film in its backlight; `what` None: all there are."""
        from mpfcad.pipeline import (
            Measuring,
            default_measure_out,
            default_what,
            job_case,
            measure_film,
        )

        case = job_case(self.model, self.file)
        folder = Path(out) if out is not None else default_measure_out(case)
        with watched(progress) as told:
            chosen = default_what(case) if what is None else tuple(what)
            measuring = Measuring(seed, effort, threads)
            record = measure_film(case, chosen, folder, measuring, told)
        return Measurement(folder, record)

    def _repr_html_(self) -> str:
        from mpfcad.api.figure import html_table

        rows = [(key, value) for key, value in self.model.given().items() if key != "name"]
        return html_table(self.name, ("table", "values"), rows)
