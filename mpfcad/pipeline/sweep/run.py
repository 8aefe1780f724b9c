"""`run_sweep`: every point traced once, by any number of processes, and what they say together."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.export import canonical_json, export_folder, refuse_foreign, write_manifest, write_text
from mpfcad.job.sweep import Sweep
from mpfcad.pipeline.point.trace import (
    POINT,
    build_point,
    compile_for,
    conventional_point,
    describe_coordinate,
)
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.pipeline.sweep.cluster import traced_points
from mpfcad.pipeline.sweep.curve import THICKNESS_AXIS, find_limits, find_optima, main_axis
from mpfcad.store import Store, versions

RECORD, DATASET, PAGE = "sweep.json", "sweep.nc", "sweep.html"


def default_sweep_out(sweep: Sweep) -> Path:
    """Return where a sweep's results go unless told otherwise."""
    return Path("exports") / f"{sweep.name}-sweep"


def run_sweep(
    sweep: Sweep,
    sweep_file: Path,
    out: Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Progress = SILENT,
) -> dict[str, Any]:
    """Trace the points that are not yet there; write dataset and page into `out`.

    Every finished point is kept in the store and never traced again.
    `scheduler` is the address of a Dask scheduler; None starts `workers` local processes. The
    results do not depend on either.

    Raises
    ------
    InputError
        when the sweep or a point of it is wrong, before anything is traced; when the scheduler does
        not answer, is lost, or a worker of it runs another version; when `out` is something else
        than an older sweep.
    """
    sweep_file, out = Path(sweep_file), Path(out)
    refuse_foreign(out.resolve(), "sweep")
    points = [build_point(sweep, sweep_file, coordinate) for coordinate in sweep.points()]
    is_cell = points[0].is_cell
    if main_axis(sweep) == THICKNESS_AXIS and not is_cell:
        # Tubes of 2008: nothing to hold against the light of LEDs.
        points.append(conventional_point(points[0], sweep.seed))
    store = Store.open(progress.note)
    keys = [point.key() for point in points]
    kept = {i: store.read_json(POINT, key) for i, key in enumerate(keys)}
    found = {i: result for i, result in kept.items() if result is not None}
    left = {i: point for i, point in enumerate(points) if i not in found}
    progress.stage(f"{len(found)} of {len(points)} points are there")
    if left:
        if scheduler is None:
            # Here, where it is told, and not by each worker for itself.
            compile_for(points[0])
        with traced_points(left, scheduler, workers) as results:
            for i, result in results:
                found[i] = store.keep_json(POINT, keys[i], result)
                name = describe_coordinate(points[i].coordinate) or "the conventional stack"
                progress.stage(f"{len(found)} of {len(points)} points: {name}")
    ordered = [found[i] for i in range(len(points))]
    count = sum(1 for _ in sweep.points())
    conventional = ordered[count] if len(points) > count else None
    ordered = ordered[:count]
    record = _describe(sweep, ordered, conventional)
    with export_folder(out, "sweep") as folder:
        from mpfcad.report import write_sweep_page

        write_text(folder / RECORD, canonical_json(record))
        write_dataset(folder / DATASET, sweep, ordered)
        write_sweep_page(folder / PAGE, record)
        write_manifest(folder, sweep.name, "sweep")
    return record


def _of_curve(table: str, key: str, result: dict[str, Any]) -> Any:
    """Return a column of the luminance over the pitch, or a map over the cell."""
    return result[table][key]


def _describe(
    sweep: Sweep, results: list[dict[str, Any]], conventional: dict[str, Any] | None
) -> dict[str, Any]:
    limits = [] if conventional is None else find_limits(sweep, results, conventional)
    return {
        "schema": 1,
        "name": sweep.name,
        "sweep": sweep.document(),
        "points": results,
        "optima": find_optima(sweep, results),
        "thickness_limits": limits,
        "conventional": conventional,
        "paths": sum(result["paths"] for result in results),
        "versions": versions(),
    }


def _places(result: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return which table of a point holds its luminance, and the places by their dimensions."""
    if "cell" not in result:
        return "luminance", {"position_pitch": result["luminance"]["position_pitch"]}
    count = len(result["cell"]["luminance_cd_m2"])
    place = ((np.arange(count) + 0.5) / count - 0.5).tolist()
    return "cell", {"position_across_period": place, "position_along_period": place}


def _likely(result: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = result["confidence"]["probability"]["marginal"]
    return found


#: Probability that a point's contrast is within the limit, and its interval, by their names.
_LIKELY: dict[str, Callable[[dict[str, Any]], Any]] = {
    "probability": lambda result: _likely(result)["value"],
    "probability_low": lambda result: _likely(result)["ci95"][0],
    "probability_high": lambda result: _likely(result)["ci95"][1],
}


def write_dataset(path: Path, sweep: Sweep, results: list[dict[str, Any]]) -> None:
    """Write the results as a netCDF file (version 3): one dimension an axis, and the position."""
    import xarray

    shape = tuple(len(values) for values in sweep.axis.values())

    def grid(pick: Callable[[dict[str, Any]], Any]) -> np.ndarray:
        values = np.array([pick(result) for result in results])
        return values.reshape(shape + values.shape[1:])

    # A dot cannot be in a name of every reader of netCDF.
    axes = [axis.replace(".", "_") for axis in sweep.axis]
    table, places = _places(results[0])
    unit = "cd m-2"
    variables = {
        "lamp_mura_contrast": grid(lambda r: r["lamp_mura_contrast"]["value"]),
        "lamp_mura_contrast_low": grid(lambda r: r["lamp_mura_contrast"]["ci95"][0]),
        "lamp_mura_contrast_high": grid(lambda r: r["lamp_mura_contrast"]["ci95"][1]),
        "mean_luminance": grid(lambda r: r["mean_luminance_cd_m2"]["value"]),
        "mean_luminance_low": grid(lambda r: r["mean_luminance_cd_m2"]["ci95"][0]),
        "mean_luminance_high": grid(lambda r: r["mean_luminance_cd_m2"]["ci95"][1]),
        "local_shift": grid(lambda r: r["local_shift_mm"]),
        "paths": grid(lambda r: r["paths"]).astype(np.int32),
    }
    data = {}
    for name, values in variables.items():
        of = unit if name.startswith("mean") else "mm" if name == "local_shift" else "1"
        data[name] = (axes, values, {"units": of})
    if "confidence" in results[0]:
        data |= {name: (axes, grid(pick), {"units": "1"}) for name, pick in _LIKELY.items()}
    for name in ("luminance", "standard_error"):
        key = f"{name}_cd_m2"
        values = grid(partial(_of_curve, table, key))
        data[name] = ([*axes, *places], values, {"units": unit})
    coordinates = dict(zip(axes, sweep.axis.values(), strict=True))
    dataset = xarray.Dataset(
        data, {**coordinates, **places}, {"title": sweep.name, "seed": str(sweep.seed)}
    )
    dataset.to_netcdf(path, format="NETCDF3_64BIT", engine="scipy")
