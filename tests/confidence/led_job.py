"""A small job under LEDs, and light over its cell that is told, not traced."""

import numpy as np
from tone_process import CALIBRATION

from mpfcad.job import build_job
from mpfcad.measure.cell.estimator import Choice, Estimator
from mpfcad.measure.cell.luminance import CellResult
from mpfcad.measure.cell.series import CellSeries
from mpfcad.measure.estimate import Estimate
from mpfcad.pipeline.plan.plan import read_plan

#: Terms 1, cos 2πu, cos 4πu along both axes.
ORDER = np.array([[i, k] for i in (0, 1, 3) for k in (0, 1, 3)])
WAY = Choice(Estimator.forward, "asked for")


def plan_of(folder, deviation=None, departure=None, **tables):
    process = {}
    if deviation is not None:
        (folder / "process.toml").write_text(CALIBRATION.format(deviation))
        process = {"process": {"calibration": "process.toml"}}
    document = {
        "name": "p",
        "map": {"series_per_mm": [[60.0, 1.0], [1.5, 0.0]]},
        "crossed": {},
        "stack": {"preset": "mini-led-4mm"},
        "cad": {"piece_mm": 0.5, "levels": 256},
        **process,
        **tables,
    }
    more = () if departure is None else (departure,)
    return read_plan(build_job(document, "job.toml"), folder / "job.toml", *more)


def flat():
    """Return the light over a cell as flat as can be: what is found is the inputs' alone."""
    coefficient = np.zeros(len(ORDER))
    coefficient[0] = 100.0
    series = CellSeries(ORDER, coefficient, np.eye(len(ORDER)) * 1e-6, 99.0, 0.0)
    one, cell = Estimate(0.0, 0.0, 0.0, 0.0), np.ones((24, 24))
    return CellResult((4.0, 4.0), series, one, one, cell, cell, {}, 1_000_000, "", True, WAY)
