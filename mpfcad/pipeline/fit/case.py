"""The cases of a fit: films in the backlight, made or found, ready to trace with values changed."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mpfcad.backlight import Stack, read_stack
from mpfcad.backlight.check import check_layers
from mpfcad.backlight.layer.stated import LAYERS
from mpfcad.boundary import reason_of
from mpfcad.errors import ExportError, InputError
from mpfcad.film import Groove, PrismFilm
from mpfcad.film.groove import Profile
from mpfcad.job import read_job
from mpfcad.job.fit import CaseTable, Fit
from mpfcad.job.model import CadTable
from mpfcad.measure import Lit, light_film
from mpfcad.pipeline.progress import SILENT

#: A uniform film repeats after any number of grooves; twenty make the meter's usual spot.
_GROOVES = 20
_LENGTH = 2.0


@dataclass(frozen=True, eq=False)
class FitCase:
    """A film in the backlight.

    Attributes
    ----------
    name
        in the fit's file
    stack
        the backlight with the case's layers, its own values in place
    own
        names of the values that the case states itself: those are not fitted in it
    mesh, offset
        of the film; left edge from a lamp's axis [mm]
    """

    name: str
    stack: Stack
    own: frozenset[str]
    mesh: Path
    offset: float

    def changed(self, values: Mapping[str, float]) -> Stack:
        """Return the case's stack with values of the backlight changed."""
        quantity = self.stack.quantity
        new = {
            name: replace(quantity[name], value=value)
            for name, value in values.items()
            if name not in self.own
        }
        return self.stack.with_values(new)

    def light(self, values: Mapping[str, float]) -> Lit:
        """Return the scene with values of the backlight changed."""
        return light_film(self.changed(values), self.mesh, self.offset)


def read_backlight(fit: Fit, file: Path) -> Stack:
    """Return the backlight of a fit, with its priors.

    Raises
    ------
    InputError
        when the stack is wrong, or not lit by tubes without end.
    """
    table = fit.stack
    source = file.parent / table.file if table.file is not None else table.preset or ""
    try:
        stack = read_stack(source, thickness=table.thickness, overrides=dict(table.override))
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
    if stack.extent != "pitch" or stack.period.along != 0 or stack.tables:
        raise InputError(
            f'{file}: stack: {stack.name}: expected tubes, extent = "pitch" and no BSDF tables'
        )
    return stack


def build_cases(fit: Fit, file: Path, stack: Stack, folder: Path) -> dict[str, FitCase]:
    """Return the cases of a fit; films that are made are written into `folder`.

    Raises
    ------
    InputError
        naming the case and what is wrong.
    """
    found = {}
    for name, table in fit.case.items():
        where = f"{file}: case.{name}"
        own = dict(table.override)
        if table.thickness_mm is not None:
            own["thickness_mm"] = table.thickness_mm
        placed = _placed(where, stack, table, own)
        inside = folder / name
        inside.mkdir()
        mesh, offset = _film(where, table, file, placed, inside)
        prism = mesh.with_name("prism.stl")
        if placed.needs_prism and not prism.is_file():
            raise InputError(
                f"{where}: film: {table.film}: expected prism.stl, or a clear resin as the prisms"
            )
        placed = placed.with_prism(prism if placed.needs_prism else None)
        found[name] = FitCase(name, placed, frozenset(own), mesh, offset)
    return found


def _placed(where: str, stack: Stack, table: CaseTable, own: dict[str, object]) -> Stack:
    from mpfcad.backlight.quantity import read_quantity

    layers = stack.layers if table.layers is None else tuple(table.layers)
    unknown = [layer for layer in layers if layer not in LAYERS and layer not in stack.own]
    if unknown or not layers:
        known = ", ".join([*LAYERS, *stack.own])
        raise InputError(f"{where}.layers: {(unknown or ['none'])[0]}: expected some of {known}")
    quantity = {
        key: read_quantity(f"{where}.override", key, entry, stack.own, stack.spec)
        for key, entry in own.items()
    }
    placed = replace(stack.with_values(quantity), layers=layers)
    check_layers(where, placed)
    placed.source.check(where)
    return placed


def _film(
    where: str, table: CaseTable, file: Path, stack: Stack, folder: Path
) -> tuple[Path, float]:
    """Return the mesh of a case's film and its offset [mm]."""
    if table.film is None:
        return _uniform(where, table, folder), 0.0
    path = file.parent / table.film
    if path.is_dir():
        return _of_export(where, path)
    if path.suffix == ".toml" and path.is_file():
        return _of_job(where, path, stack, folder)
    if not path.is_file():
        raise InputError(f"{where}.film: {path}: no such file: expected a mesh, job or export")
    return path, table.offset_mm


def _uniform(where: str, table: CaseTable, folder: Path) -> Path:
    from mpfcad.cad import write_stl

    groove = Groove(table.pitch_um / 1000, table.depth_um / 1000)
    empty = groove.curvature_empty
    curvature = empty if table.curvature_per_mm is None else table.curvature_per_mm
    if table.profile == "filled" and curvature > empty:
        raise InputError(
            f"{where}.curvature_per_mm: {curvature:g}: expected at most {empty:g}: an empty groove"
        )

    def film(of: float, profile: Profile) -> PrismFilm:
        return PrismFilm(
            groove, table.base_um / 1000, _LENGTH, profile, np.full(_GROOVES, float(of))
        )

    angle = CadTable().angle_tolerance
    write_stl(film(curvature, table.profile), folder / "film.stl", angle)
    write_stl(film(empty, "filled"), folder / "prism.stl", angle, name="prisms")
    return folder / "film.stl"


def _of_export(where: str, folder: Path) -> tuple[Path, float]:
    from mpfcad.export import check_manifest

    try:
        manifest = check_manifest(folder)
        if "verification.json" not in manifest["files"]:
            raise ExportError(f"{folder}: holds no verification.json")
        record = json.loads((folder / "verification.json").read_text("utf-8"))
        traced = record["provenance"]["traced"]
        return folder / traced["file"], float(traced["offset_mm"])
    except (ExportError, KeyError, ValueError, OSError) as error:
        raise InputError(
            f"{where}.film: {reason_of(error)}: expected an export of mpfcad run"
        ) from None


def _of_job(where: str, path: Path, stack: Stack, folder: Path) -> tuple[Path, float]:
    """Write a job's film and return it; it has to lie over the same lamp pitch."""
    from mpfcad.pipeline.plan.plan import read_plan
    from mpfcad.pipeline.run.make import write_cad

    plan = read_plan(read_job(path), path)
    pitch, own = stack.period.across, plan.stack.period.across
    if abs(pitch - own) > 1e-6 or plan.stack.period.along or plan.crossed is not None:
        raise InputError(
            f"{where}.film: {path.name}: over a lamp pitch of {own:g} mm: expected the "
            f"backlight's {pitch:g} mm"
        )
    write_cad(plan, folder, ("stl",), SILENT)
    return folder / plan.file("film", "stl"), plan.offset
