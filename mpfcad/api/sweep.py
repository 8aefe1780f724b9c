"""A sweep as an object: films over any values of a job."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.api.progress import watched
from mpfcad.api.result import Export
from mpfcad.api.source import Sourced

if TYPE_CHECKING:
    import xarray as xr

    from mpfcad.job.sweep import Sweep as Model
    from mpfcad.pipeline import Progress


@dataclass(frozen=True, repr=False)
class SweepResult(Export):
    """The points of a sweep.

    Attributes
    ----------
    folder
        the export: dataset, record, page
    record
        sweep.json (docs/design.md)
    """

    record: dict[str, Any]

    @cached_property
    def dataset(self) -> "xr.Dataset":
        """Contrast and luminance with their errors over the sweep's axes, units in the names."""
        import xarray as xr

        with xr.open_dataset(self.folder / "sweep.nc") as stored:
            return stored.load()

    def _lines(self) -> list[tuple[str, object]]:
        sizes = self.dataset.sizes.items()
        return [("points", " × ".join(f"{size} {name}" for name, size in sizes))]

    def _repr_html_(self) -> str:
        return str(self.dataset._repr_html_())


class Sweep(Sourced["Model"]):
    """Films over any values of a job.

    Parameters
    ----------
    source
        path of a sweep's TOML file, or its tables as a dict (docs/design.md)
    folder
        where a dict's file names are taken from (None: the working folder)

    Raises
    ------
    InputError
        naming the first field that is wrong.

    Examples
    --------
    >>> Sweep({"name": "c", "axis": {"map.curvature_per_mm": [50.0, 60.0]}}).name
    'c'
    """

    @staticmethod
    def _model_class() -> "type[Model]":
        from mpfcad.job.sweep import Sweep as Model

        return Model

    def run(
        self,
        out: str | Path | None = None,
        *,
        scheduler: str | None = None,
        workers: int | None = None,
        progress: "bool | Progress" = False,
    ) -> SweepResult:
        """Trace the points that are not kept yet; results do not depend on scheduler or workers."""
        from mpfcad.pipeline import default_sweep_out, run_sweep

        folder = Path(out) if out is not None else default_sweep_out(self.model)
        with watched(progress) as told:
            record = run_sweep(
                self.model, self.file, folder, scheduler=scheduler, workers=workers, progress=told
            )
        return SweepResult(folder, record)
