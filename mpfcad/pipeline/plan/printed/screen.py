"""From the job's `[mask]` to the rules of a mask, and the screen's mesh."""

from dataclasses import replace
from pathlib import Path

from mpfcad.boundary import named_file
from mpfcad.errors import InputError
from mpfcad.film import Groove, Process, levelling_length
from mpfcad.job import Job
from mpfcad.job.screen import MaskTable, MeshTable
from mpfcad.mask.fabric import (
    Mesh,
    build_mesh,
    find_mesh,
    read_catalogue,
    shipped_catalogue,
)
from mpfcad.mask.rule import MaskRules
from mpfcad.mask.screen.moire import MoireSetting
from mpfcad.units import um

#: How far depth over half the pitch may be from 1 for the flow of a groove of 90°.
RIGHT_ANGLE = 0.02
#: The last digit of a data sheet's open area [%] and ink volume [cm³/m²].
ROUNDING = 1.0


def mask_rules(table: MaskTable, where: str, levelling: float | None = None) -> MaskRules:
    """Return the rules that a job's `[mask]` gives; `levelling` [mm] replaces its length.

    Raises
    ------
    InputError
        that begins with `where`, for a mesh that there is not.
    """
    return MaskRules(
        pattern=table.pattern,
        period=table.period,
        min_aperture=table.min_aperture,
        min_web=table.min_web,
        angle=table.angle,
        dot=table.dot,
        levelling_length=table.levelling_length if levelling is None else levelling,
        mesh=None if table.mesh is None else screen_mesh(table.mesh, where),
    )


def screen_mesh(table: MeshTable, where: str) -> Mesh:
    """Return the mesh of a job's `[mask.mesh]`.

    Raises
    ------
    InputError
        that begins with `where`, for an unknown name or figures that no weave has.
    """
    where = f"{where}: mask.mesh"
    if table.name is not None:
        return find_mesh(table.name, emulsion=table.emulsion, where=where)
    assert table.threads_per_cm is not None  # the job has looked
    mesh = build_mesh(
        table.threads_per_cm,
        table.thread,
        opening=table.opening,
        thickness=table.thickness,
        emulsion=table.emulsion,
        material=table.material,
        where=f"{where}.",
    )
    return _beside_stated(mesh, table, where)


def _beside_stated(mesh: Mesh, table: MeshTable, where: str) -> Mesh:
    """Return a mesh whose source has the open area and ink volume that the job states beside it.

    Raises
    ------
    InputError
        when they are not what opening, thread and thickness give, within their widths.
    """
    parts = []
    area_width = 2 * mesh.opening_width / mesh.opening
    for name, words, unit, stated, geometry, width in (
        ("open_area_percent", "open area", "%", table.open_area_percent,
         100 * mesh.open_area, area_width),
        ("ink_volume_cm3_m2", "ink volume", "cm³/m²", table.ink_volume_cm3_m2,
         mesh.fabric_volume / um, mesh.volume_width * mesh.volume / mesh.fabric_volume),
    ):  # fmt: skip
        if stated is None:
            continue
        room = geometry * width + ROUNDING
        if abs(stated - geometry) > room:
            raise InputError(
                f"{where}.{name}: {stated:g}: expected {geometry:.3g} ± {room:.2g} {unit}: what "
                f"opening {mesh.opening / um:.3g}, thread {mesh.thread / um:g} and thickness "
                f"{mesh.thickness / um:.3g} µm give"
            )
        parts.append(f"{words} {stated:g} {unit} stated, {geometry:.3g} by its figures")
    return replace(mesh, source="; ".join((mesh.source, *parts)))


def with_own_catalogue(job: Job, job_file: Path) -> Job:
    """Return a job whose mesh of a weaver's table is stated by its numbers.

    So an export needs no table to be verified.

    Raises
    ------
    InputError
        when the table is wrong, or has no such mesh.
    """
    table = job.mask.mesh
    if table is None or table.name is None or table.catalogue is None or table.is_auto:
        return job
    where = f"{job_file}: mask.mesh"
    meshes = catalogue_of(job, job_file)
    return with_mesh(job, find_mesh(table.name, catalogue=meshes, where=where))


def catalogue_of(job: Job, job_file: Path) -> tuple[Mesh, ...]:
    """Return the meshes that a job's may be: its weaver's table, or the shipped one.

    Raises
    ------
    InputError
        when the table is not there, or is wrong.
    """
    name = None if job.mask.mesh is None else job.mask.mesh.catalogue
    if name is None:
        return shipped_catalogue()
    where = f"{job_file}: mask.mesh.catalogue"
    return read_catalogue(named_file(where, job_file.parent, name, "a table of meshes (CSV)"))


def with_mesh(job: Job, mesh: Mesh) -> Job:
    """Return a job with a mesh: by name, or the figures that are stated of one of a weaver's table.

    Emulsion, angle and release of the job stay.
    """
    kept = ("emulsion_um", "angle_deg", "release")
    given = {} if job.mask.mesh is None else job.mask.mesh.model_dump(exclude_unset=True)
    stated = {name: value for name, value in given.items() if name in kept}
    if mesh.coated(0.0) in shipped_catalogue():
        table = MeshTable(name=mesh.name, **stated)
    else:
        figures = {
            f"{name}_um": round(getattr(mesh, name) / um, 6)
            for name in ("opening", "thickness")
            if name not in mesh.computed
        }
        table = MeshTable(
            threads_per_cm=round(mesh.count * 10, 9),
            thread_um=round(mesh.thread / um, 9),
            material=mesh.material,
            **figures,
            **stated,
        )
    mask = job.mask.model_copy(update={"mesh": table})
    mask.model_fields_set.add("mesh")
    changed = job.model_copy(update={"mask": mask})
    changed.model_fields_set.add("mask")
    return changed


def job_levelling(
    job: Job, process: Process, groove: Groove, smallest_ratio: float, where: str
) -> float | None:
    """Return the levelling length [mm] of the least filled groove; None: the job states it.

    The resin is as wet as it was printed: its fill is the dried one over the solids fraction.

    Raises
    ------
    InputError
        when the job states both, a groove is not of 90°, or the resin does not run.
    """
    return flow_levelling(job, groove, float(process.fill_fraction(smallest_ratio)), where)


def flow_levelling(job: Job, groove: Groove, fill: float, where: str) -> float | None:
    """Return the same of a groove by its fill, 0…1, once dried.

    Raises
    ------
    InputError
        as `job_levelling`.
    """
    flow = job.process.flow
    if flow is None:
        return None
    if "levelling_length_mm" in job.mask.model_fields_set:
        raise InputError(
            f"{where}: mask.levelling_length_mm: {job.mask.levelling_length_mm:g}: expected to be "
            f"left out when process.viscosity_pa_s is given"
        )
    if abs(2 * groove.depth / groove.pitch - 1) > RIGHT_ANGLE:
        raise InputError(
            f"{where}: process.viscosity_pa_s: expected a groove of 90° (depth = pitch/2); for "
            f"another state mask.levelling_length_mm"
        )
    try:
        return levelling_length(fill / job.process.solids_fraction, groove.depth, **flow)
    except InputError as error:
        raise InputError(f"{where}: process.{error}") from None


def moire_setting(table: MaskTable) -> MoireSetting:
    """Return what a mask is looked at with and through."""
    angle = MoireSetting.mesh_angle if table.mesh is None else table.mesh.angle
    return MoireSetting(angle, table.pixel, table.viewing_distance)
