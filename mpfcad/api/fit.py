"""A fit as an object: the backlight that measurements hold."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.api.figure import Figure, html_table
from mpfcad.api.progress import watched
from mpfcad.api.result import Export
from mpfcad.api.source import Sourced

if TYPE_CHECKING:
    import xarray as xr

    from mpfcad.job.fit import Fit as Model
    from mpfcad.pipeline import Progress


@dataclass(frozen=True, repr=False)
class FitResult(Export):
    """The fitted backlight.

    Attributes
    ----------
    folder
        the export: stack, covariance, record, page
    record
        fit.json (docs/fit.md)
    """

    record: dict[str, Any]

    @property
    def stack_file(self) -> Path:
        """The fitted backlight, for `stack.file` of a job."""
        return self.folder / f"{self.record['name']}.toml"

    @cached_property
    def values(self) -> dict[str, Figure]:
        """Each value that was sought, by its name with unit, with its 95 % interval."""
        return {row["name"]: Figure.of(row) for row in self.record["values"]}

    @cached_property
    def predictions(self) -> dict[str, Figure]:
        """Each figure that was asked for, with its 95 % interval."""
        return {row["name"]: Figure.of(row) for row in self.record["predictions"]}

    @cached_property
    def covariance(self) -> "xr.DataArray":
        """The values' covariance over their names, float64, in the units of the names."""
        import xarray as xr

        names = self.record["covariance"]["names"]
        return xr.DataArray(
            self.record["covariance"]["matrix"], {"value": names, "other": names},
            ("value", "other"),
        )  # fmt: skip

    def _lines(self) -> list[tuple[str, object]]:
        return [*self.values.items(), *self.predictions.items()]

    def _repr_html_(self) -> str:
        return html_table(str(self.record["name"]), ("value", "fitted [95 %]"), self._lines())


class Fit(Sourced["Model"]):
    """A backlight's values, sought from what was measured of it.

    Parameters
    ----------
    source
        path of a fit's TOML file, or its tables as a dict (docs/fit.md)
    folder
        where a dict's file names are taken from (None: the working folder)

    Raises
    ------
    InputError
        naming the first field that is wrong.

    Examples
    --------
    >>> measured = {"case": "bef", "of": "luminance", "value": 6900.0, "sigma": 50.0}
    >>> Fit({"name": "b", "case": {"bef": {}}, "measurement": [measured]}).name
    'b'
    """

    @staticmethod
    def _model_class() -> "type[Model]":
        from mpfcad.job.fit import Fit as Model

        return Model

    def run(
        self,
        out: str | Path | None = None,
        *,
        effort: str | None = None,
        threads: int | None = None,
        progress: "bool | Progress" = False,
    ) -> FitResult:
        """Find the values; traces that are kept are not done again."""
        from mpfcad.pipeline import FitSetting, default_fit_out, fit_backlight

        folder = Path(out) if out is not None else default_fit_out(self.model)
        setting = FitSetting(effort, threads)
        with watched(progress) as told:
            return FitResult(folder, fit_backlight(self.model, self.file, folder, setting, told))
