"""`run_design`: a design's map, its job and the page of its iterations; every trace is kept."""

import os
from pathlib import Path

import numpy as np

from mpfcad.export import canonical_json, export_folder, refuse_foreign, write_manifest, write_text
from mpfcad.job.design import Design
from mpfcad.pipeline.design.likely import search_likely
from mpfcad.pipeline.design.reach import describe_reach
from mpfcad.pipeline.design.record import describe_design
from mpfcad.pipeline.design.thickness import ThicknessSearch
from mpfcad.pipeline.design.work import DesignWork
from mpfcad.pipeline.effort import available_threads
from mpfcad.pipeline.progress import SILENT, Progress

RECORD, PAGE = "design.json", "design.html"


def default_design_out(design: Design) -> Path:
    """Return where a design's job goes unless told otherwise."""
    return Path("exports") / f"{design.name}-design"


def run_design(
    design: Design,
    design_file: Path,
    out: Path,
    *,
    threads: int | None = None,
    progress: Progress = SILENT,
) -> Path:
    """Search a map, write job, map and page into the folder `out`, and return the job's path.

    Traces that are done are kept in the store and not repeated; the bytes are the same as without
    an interruption.

    Raises
    ------
    InputError
        when the design or a file it names is wrong; `out` is then as it was.
    """
    design_file, out = Path(design_file), Path(out)
    refuse_foreign(out.resolve(), "design")
    threads = threads or available_threads()
    if design.thickness is None:
        found = None
        work = DesignWork(design, design_file, threads, progress)
    else:
        range_search = ThicknessSearch(design, design_file, threads, progress)
        least = range_search.search()
        found = range_search.describe(least)
        work = range_search.work(least or design.thickness.max_mm)
    done = work.search_maps(design.goal.contrast_target)
    reach = describe_reach(work, done) if design.search.method == "response" else None
    chosen, likely = work.best(done), None
    if design.goal.aim == "confidence":
        likeliest = search_likely(work, done)
        chosen, likely = likeliest.chosen, likeliest.record
        done = [*done, *likeliest.traced]
    record = describe_design(work, done, chosen, reach, found, likely)
    with export_folder(out, "design") as folder:
        best = np.array(chosen.rows)
        work.write_job(folder, best, os.path.relpath(design_file.parent, out))
        write_text(folder / RECORD, canonical_json(record))
        from mpfcad.report import write_design_page

        write_design_page(folder / PAGE, record)
        write_manifest(folder, design.name, "design")
    return out / f"{design.name}.toml"
