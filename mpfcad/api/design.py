"""A design as an object: the curvature map for a backlight, found and verified."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.api.figure import html_table
from mpfcad.api.job import Job
from mpfcad.api.progress import watched
from mpfcad.api.result import Export
from mpfcad.api.source import Sourced

if TYPE_CHECKING:
    from mpfcad.job.design import Design as Model
    from mpfcad.pipeline import Progress


@dataclass(frozen=True, repr=False)
class DesignResult(Export):
    """A map that was found.

    Attributes
    ----------
    folder
        the export: map, job, page
    record
        design.json (docs/design.md)
    job_file
        the job of the film that was found
    """

    record: dict[str, Any]
    job_file: Path

    @property
    def job(self) -> Job:
        """The job of the film, ready to run."""
        return Job(self.job_file)

    def _lines(self) -> list[tuple[str, object]]:
        return [("job", self.job_file)]

    def _repr_html_(self) -> str:
        rows = [(path.name, f"{path.stat().st_size:,}") for path in self.files]
        return html_table(f"design {self.job_file.stem}", ("file", "bytes"), rows)


class Design(Sourced["Model"]):
    """A backlight for which the curvature map is wanted.

    Parameters
    ----------
    source
        path of a design's TOML file, or its tables as a dict (docs/design.md)
    folder
        where a dict's file names are taken from (None: the working folder)

    Raises
    ------
    InputError
        naming the first field that is wrong.

    Examples
    --------
    >>> design = Design({"name": "slim", "stack": {"thickness_mm": 16.0}})
    >>> design.name
    'slim'
    """

    @staticmethod
    def _model_class() -> "type[Model]":
        from mpfcad.job.design import Design as Model

        return Model

    def search(
        self,
        out: str | Path | None = None,
        *,
        threads: int | None = None,
        progress: "bool | Progress" = False,
    ) -> DesignResult:
        """Find the map; `result.job.run()` then verifies it. An interrupted search goes on."""
        from mpfcad.pipeline import default_design_out, run_design

        folder = Path(out) if out is not None else default_design_out(self.model)
        with watched(progress) as told:
            job_file = run_design(self.model, self.file, folder, threads=threads, progress=told)
        record = json.loads((folder / "design.json").read_text("utf-8"))
        return DesignResult(folder, record, job_file)
