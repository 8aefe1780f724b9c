"""From the job's `[mask]` to the rules of a mask, the screen's mesh and its process."""

from mpfcad.errors import InputError
from mpfcad.film import Groove, Process
from mpfcad.job.model import MaskTable, MeshTable
from mpfcad.mask.fabric import Mesh, build_mesh, find_mesh
from mpfcad.mask.rule import MaskRules
from mpfcad.mask.screen.moire import MoireSetting


def mask_rules(table: MaskTable, where: str) -> MaskRules:
    """Return the rules that a job's `[mask]` gives.

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
        levelling_length=table.levelling_length,
        mesh=None if table.mesh is None else screen_mesh(table.mesh, where),
    )


def screen_mesh(table: MeshTable, where: str) -> Mesh:
    """Return the mesh of a job's `[mask.mesh]`.

    Raises
    ------
    InputError
        that begins with `where`, for an unknown name or a mesh finer than its thread.
    """
    where = f"{where}: mask.mesh"
    if table.name is not None:
        return find_mesh(table.name, emulsion=table.emulsion, where=where)
    return build_mesh(
        table.threads_per_cm,
        table.thread,
        thickness=table.thickness,
        emulsion=table.emulsion,
        where=where,
    )


def mesh_process(table: MaskTable, calibrated: bool, groove: Groove, where: str) -> Process | None:
    """Return the process that mesh and `release` give; None when the job states no release.

    Raises
    ------
    InputError
        when the job has a calibration as well.
    """
    if table.mesh is None or table.mesh.release is None:
        return None
    if calibrated:
        raise InputError(
            f"{where}: mask.mesh.release: {table.mesh.release:g}: must be left out when "
            f"process.calibration is given: each states the transfer factor"
        )
    mesh = screen_mesh(table.mesh, where)
    factor = mesh.transfer_factor(groove, table.mesh.release)
    source = (
        f"mesh {mesh.name}: {table.mesh.release:.0%} of {mesh.volume * 1000:.4g} cm³/m² over "
        f"{groove.area / groove.pitch * 1000:.4g} cm³/m² of a full groove"
    )
    caveat = "theoretical volume of the mesh and a stated release: print and measure"
    return Process.build(groove, "volume", [1.0], [factor], source, (caveat,))


def moire_setting(table: MaskTable) -> MoireSetting:
    """Return what a mask is looked at with and through."""
    angle = MoireSetting.mesh_angle if table.mesh is None else table.mesh.angle
    return MoireSetting(angle, table.pixel, table.viewing_distance)
