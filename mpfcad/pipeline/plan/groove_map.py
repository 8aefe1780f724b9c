"""The map of a job that varies across the grooves alone: a file, rows, or one curvature."""

from pathlib import Path

import numpy as np

from mpfcad.backlight import Stack
from mpfcad.errors import InputError
from mpfcad.film import (
    CurvatureMap,
    CurvatureTable,
    build_curvature_map,
    check_curvature,
    read_curvature_table,
)
from mpfcad.job import Job, MapTable


def read_map(job: Job, job_file: Path, stack: Stack, table: MapTable) -> CurvatureMap:
    """Return the map of a table, `[map]` or `[crossed]`, of a job.

    Raises
    ------
    InputError
        when the file or a value of the map is wrong.
    """
    groove, uniform = job.film.groove, table.curvature_per_mm
    if uniform is not None:
        where = f"{job_file}: map.curvature_per_mm"
        check_curvature(uniform, groove, job.film.profile, where)
        return CurvatureMap.uniform(uniform)
    if table.extent == "cell":
        raise InputError(f"{job_file}: map.extent: cell: is for stacks of LEDs: expected 'pitch'")
    return build_curvature_map(
        _map_table(table, job_file),
        extent=table.extent,
        repeat=table.repeat,
        profile=job.film.profile,
        groove=groove,
        lamp_pitch=stack.source.cell.across,
        panel_width=stack.panel_width,
    )


def _map_table(table: MapTable, job_file: Path) -> CurvatureTable:
    if table.rows is None:
        assert table.file is not None  # exactly one of file, curvature_per_mm, rows is given
        return read_curvature_table(job_file.parent / table.file)
    position, curvature = np.array(table.rows, float).T
    return CurvatureTable(f"{job_file}: map.rows", position, curvature, "row {}".format)
