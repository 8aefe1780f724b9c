"""What the commands found, as objects: records, figures with intervals, xarray datasets, plots."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.api.figure import Figure, html_table, text_lines

if TYPE_CHECKING:
    import plotly.graph_objects as go
    import xarray as xr


#: Figures that a measurement prints.
_SHOWN = 6


@dataclass(frozen=True, repr=False)
class Export:
    """A folder of files that a command has made, each hashed in its manifest.

    Attributes
    ----------
    folder
        the export
    """

    folder: Path

    @cached_property
    def files(self) -> tuple[Path, ...]:
        """Every file of the export, by name."""
        return tuple(path for path in sorted(self.folder.iterdir()) if path.is_file())

    def _lines(self) -> list[tuple[str, object]]:
        """Return the rows that stand before the files when it is printed."""
        return []

    def __repr__(self) -> str:
        files = ", ".join(path.name for path in self.files)
        return text_lines(str(self.folder), [*self._lines(), ("files", files)])

    def _repr_html_(self) -> str:
        rows = [(path.name, f"{path.stat().st_size:,}") for path in self.files]
        return html_table(str(self.folder), ("file", "bytes"), rows)


@dataclass(frozen=True, repr=False)
class Trace:
    """The luminance over the lamp pitch of a film in a backlight.

    Attributes
    ----------
    record
        everything that was found, as plain values; `mpfcad trace --json` prints the same
    """

    record: dict[str, Any]

    @property
    def contrast(self) -> Figure:
        """Lamp-Mura contrast (Lmax - Lmin)/(Lmax + Lmin), with its 95 % interval."""
        return Figure.of(self.record["lamp_mura_contrast"])

    @property
    def mean_luminance_cd_m2(self) -> Figure:
        """Mean luminance along the meter's axis [cd/m²], with its 95 % interval."""
        return Figure.of(self.record["mean_luminance_cd_m2"])

    @cached_property
    def luminance(self) -> "xr.Dataset":
        """`luminance_cd_m2` and `standard_error_cd_m2` over `position_pitch`, float64."""
        import xarray as xr

        columns = {key: np.array(values) for key, values in self.record["luminance"].items()}
        position = columns.pop("position_pitch")
        return xr.Dataset(
            {key: ("position_pitch", values) for key, values in columns.items()},
            coords={"position_pitch": position},
        )

    def plot(self) -> "go.Figure":
        """Return the luminance over the pitch with its 95 % band."""
        import plotly.graph_objects as go

        x = self.luminance["position_pitch"].values
        y = self.luminance["luminance_cd_m2"].values
        half = 1.96 * self.luminance["standard_error_cd_m2"].values
        figure = go.Figure()
        figure.add_scatter(
            x=np.concatenate([x, x[::-1]]),
            y=np.concatenate([y + half, (y - half)[::-1]]),
            fill="toself",
            line_width=0,
            name="95 %",
        )
        figure.add_scatter(x=x, y=y, name="luminance")
        figure.update_layout(xaxis_title="position [lamp pitch]", yaxis_title="luminance [cd/m²]")
        return figure

    def _rows(self) -> list[tuple[str, object]]:
        return [
            ("lamp-Mura contrast", self.contrast),
            ("mean luminance [cd/m²]", self.mean_luminance_cd_m2),
        ]

    def __repr__(self) -> str:
        return text_lines("trace", self._rows())

    def _repr_html_(self) -> str:
        return html_table("trace", ("figure", "value [95 %]"), self._rows())


@dataclass(frozen=True, repr=False)
class Run(Trace):
    """A verified film: files, figures and verdict.

    Attributes
    ----------
    record
        verification.json (docs/verification.md)
    folder
        the export
    """

    folder: Path

    @property
    def verdict(self) -> str:
        """PASS, MARGINAL, FAIL or INCONCLUSIVE: that of the worst gate."""
        return str(self.record["verdict"])

    @property
    def report(self) -> Path:
        """The page that a person decides from."""
        return self.folder / "report.html"

    @property
    def files(self) -> tuple[Path, ...]:
        """Every file of the export, by name."""
        return Export(self.folder).files

    @cached_property
    def gates(self) -> "xr.Dataset":
        """`value`, `low`, `high`, `limit` (float64) and `outcome` of each gate."""
        import xarray as xr

        gates = self.record["gates"]
        found = [Figure.of(gate) for gate in gates]
        column = {name: [getattr(one, name) for one in found] for name in Figure._fields}
        column |= {"limit": [float(gate["limit"]) for gate in gates]}
        column |= {"outcome": [gate["outcome"] for gate in gates]}
        return xr.Dataset(
            {name: ("gate", values) for name, values in column.items()},
            coords={"gate": [gate["name"] for gate in gates]},
        )

    @cached_property
    def curvature(self) -> "xr.Dataset":
        """The columns of curvature.csv over `groove`; empty for a map C(x, y)."""
        import csv

        import xarray as xr

        path = self.folder / "curvature.csv"
        if not path.is_file():
            return xr.Dataset()
        with path.open(newline="", encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        column = {name: [row[i] for row in rows] for i, name in enumerate(head)}
        groove = np.array(column.pop("groove"), int)
        values = {k: np.array([float(x) if x else np.nan for x in v]) for k, v in column.items()}
        return xr.Dataset(
            {name: ("groove", v) for name, v in values.items()}, coords={"groove": groove}
        )

    def __repr__(self) -> str:
        files = f"{self.folder}: {', '.join(path.name for path in self.files)}"
        return text_lines(
            f"{self.record['name']}: {self.verdict}", [*self._rows(), ("files", files)]
        )

    def _repr_html_(self) -> str:
        rows = [
            (g["outcome"], g["name"], Figure.of(g), f"{g['limit']:.6g}")
            for g in self.record["gates"]
        ]
        title = f"{self.record['name']}: {self.verdict}"
        return html_table(title, ("outcome", "gate", "value [95 %]", "limit"), rows)


@dataclass(frozen=True, repr=False)
class Measurement(Export):
    """Photometric figures of a film in a backlight.

    Attributes
    ----------
    folder
        the export, with its page
    record
        measure.json (docs/measure.md)
    """

    record: dict[str, Any]

    @cached_property
    def figures(self) -> dict[str, Figure]:
        """Every figure that has an interval, by its place in the record (`contrast.…`)."""
        return dict(_figures(self.record, ""))

    def _lines(self) -> list[tuple[str, object]]:
        rows: list[tuple[str, object]] = list(self.figures.items())
        more = len(rows) - _SHOWN
        return rows[:_SHOWN] + ([("…", f"and {more} more in .figures")] if more > 0 else [])

    def _repr_html_(self) -> str:
        rows = list(self.figures.items())
        return html_table(str(self.record["name"]), ("figure", "value [95 %]"), rows)


def _figures(entry: Any, name: str) -> list[tuple[str, Figure]]:
    if not isinstance(entry, dict):
        return []
    if "ci95" in entry and "value" in entry:
        return [(name, Figure.of(entry))]
    found = []
    for key, value in entry.items():
        found += _figures(value, f"{name}.{key}" if name else key)
    return found
