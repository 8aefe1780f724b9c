"""`make_mould`: the mould of a job's film, its turning table and drawings, all checked."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.cad.shape.mould import Mould
from mpfcad.cad.step.file import Header
from mpfcad.export import canonical_json, export_folder, write_manifest, write_text
from mpfcad.film import MadeFilm
from mpfcad.gate import demand
from mpfcad.job import Job
from mpfcad.pipeline.kind import kind_of, step_header
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.pipeline.run.make import write_curvature
from mpfcad.units import um

LOSS_COLUMNS = "groove,position_mm,lost_area_um2,lost_height_um"


@dataclass(frozen=True)
class MouldSetting:
    """How a mould is made of a film; lengths in mm.

    Attributes
    ----------
    shrinkage
        film = mould · (1 - shrinkage)
    backing
        thickness of the mould behind its valleys
    tool_radius
        nose radius of the turning tool; 0 is sharp
    """

    shrinkage: float = 0.0
    backing: float = 5.0
    tool_radius: float = 0.0


def make_mould(
    job: Job, job_file: Path, out: Path, setting: MouldSetting, progress: Progress = SILENT
) -> dict[str, Any]:
    """Make the mould of a job's CAD piece into the folder `out`; return its mould.json.

    Raises
    ------
    InputError
        when the job is wrong, or the tool's nose does not fit the film.
    ExportError
        when a file does not read back as what it should hold.
    """
    progress.stage(f"reading {job_file}")
    plan = read_plan(job, job_file)
    made = kind_of(plan.drawn, job.cad).mould_film(str(job_file))
    tolerance = job.cad.angle_tolerance
    with export_folder(out, "mould") as folder:
        write_curvature(plan, folder)
        mould = _build(made, setting)
        header = step_header(job.cad)
        volume = _write_solids(made, mould, setting, folder, tolerance, progress, header)
        _write_drawings(mould, folder, tolerance, progress)
        _write_losses(mould, folder / "tool-loss.csv")
        record = _record(job, made, mould, setting, volume)
        write_text(folder / "mould.json", canonical_json(record))
        write_manifest(folder, job.name, "mould")
    return record


def _build(made: MadeFilm, setting: MouldSetting, sliver: float | None = None) -> Mould:
    from mpfcad.cad.shape.mould import build_mould

    return build_mould(
        made.film,
        made.imperfection,
        shrinkage=setting.shrinkage,
        backing=setting.backing,
        tool_radius=setting.tool_radius,
        sliver=sliver,
    )


def _write_solids(
    made: MadeFilm,
    mould: Mould,
    setting: MouldSetting,
    folder: Path,
    tolerance: float,
    progress: Progress,
    header: Header,
) -> dict[str, float]:
    """Write mould.step and mould.stl; return the volumes [mm³] read back from them."""
    from mpfcad.cad.check import section as section_check
    from mpfcad.cad.file import stl
    from mpfcad.cad.shape import section_mesh
    from mpfcad.cad.shape.mesh import mesh_sliver
    from mpfcad.cad.step import section as section_step

    progress.stage("writing mould.step")
    path, colour = folder / "mould.step", section_step.MOULD_COLOUR
    section_step.write_section_step(
        mould.section, path, name="mould", body="mould", colour=colour, header=header
    )
    step = section_check.check_section_step(path, mould.section, "mould")
    demand(step.gates)
    volume = {"mould.step": step.bodies["mould"]}
    progress.stage("writing mould.stl")
    path = folder / "mould.stl"
    coarse = _build(made, setting, mesh_sliver(made.film)).section
    stl.write_mesh(section_mesh.build_section_mesh(coarse, tolerance), path, "mould")
    check = section_check.check_section_stl(path, coarse, tolerance)
    demand(check.gates)
    volume["mould.stl"] = check.volume
    return volume


def _write_drawings(mould: Mould, folder: Path, tolerance: float, progress: Progress) -> None:
    """Write profile.csv, mould.dxf and film.dxf."""
    from mpfcad.cad.file.dxf import check_dxf, write_dxf
    from mpfcad.cad.shape.turning import build_turning_table, write_turning_table

    progress.stage("writing profile.csv")
    table = build_turning_table(mould.cut, mould.tool_radius, tolerance)
    write_turning_table(table, folder / "profile.csv")
    for name, section in (("mould.dxf", mould.section), ("film.dxf", mould.film)):
        progress.stage(f"writing {name}")
        write_dxf(section, folder / name, tolerance)
        check_dxf(folder / name, section)


def _write_losses(mould: Mould, path: Path) -> None:
    """Write what the tool leaves standing, one row a groove of the mould, left to right."""
    centre = (mould.tip_position[1:] + mould.tip_position[:-1]) / 2
    rows = np.column_stack(
        [
            np.arange(len(centre)),
            centre,
            mould.lost_area / um**2,
            mould.lost_height / um,
        ]
    )
    with path.open("w", encoding="utf-8", newline="\n") as file:
        np.savetxt(
            file, rows, ("%d", "%.6f", "%.6f", "%.6f"), ",", header=LOSS_COLUMNS, comments=""
        )


def _record(
    job: Job, made: MadeFilm, mould: Mould, setting: MouldSetting, volume: dict[str, float]
) -> dict[str, Any]:
    """Return mould.json."""
    shrink = 1 - setting.shrinkage
    thickness = mould.film.thickness + setting.backing * shrink
    block = mould.film.width * mould.film.length * thickness
    together = volume["mould.step"] * shrink**3 + mould.film.volume
    warnings: list[str] = []
    record = {
        "schema": 1,
        "name": job.name,
        "film": job.film.model_dump(mode="json"),
        "groove_count": made.film.groove_count,
        "shrinkage": setting.shrinkage,
        "backing_mm": setting.backing,
        "tool_radius_um": setting.tool_radius / um,
        "mould": {
            "width_mm": mould.section.width,
            "length_mm": mould.section.length,
            "thickness_mm": mould.section.thickness,
            "volume_mm3": volume["mould.step"],
            "mesh_volume_mm3": volume["mould.stl"],
        },
        "block": {
            "film_volume_mm3": mould.film.volume,
            "mould_volume_shrunk_mm3": volume["mould.step"] * shrink**3,
            "block_volume_mm3": block,
            "relative_difference": together / block - 1,
        },
        "not_cut": {
            "lost_area_um2": {
                "mean": float(mould.lost_area.mean()) / um**2,
                "max": float(mould.lost_area.max()) / um**2,
            },
            "lost_height_um": {
                "mean": float(mould.lost_height.mean()) / um,
                "max": float(mould.lost_height.max()) / um,
            },
        },
        "warnings": warnings,
    }
    if mould.lost_height.max() > 0:
        warnings.append(
            f"a tool of nose radius {setting.tool_radius / um:g} µm cannot reach into the mould's "
            f"valleys: the film's tips will be up to {mould.lost_height.max() / um:.3g} µm lower "
            f"and lose up to {mould.lost_area.max() / um**2:.3g} µm² a groove"
        )
    return record
