"""Readers of the files that a run wrote: masks, CAD files, the record; and files to begin from."""

import functools
import io
import json
import tempfile
import zipfile
import zlib
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np

from mpfcad.errors import ExportError

from .kind import Reader

#: The smallest panel: one lamp, 80 grooves.
JOB = """name = "a"
[map]
curvature_per_mm = 60.0
[stack.override]
lamp_count = 1
lamp_pitch_mm = 4.0
lamp_radius_mm = 0.2
lamp_height_mm = 0.5
panel_width_mm = 4.0
panel_length_mm = 2.0
"""
MASKS = ("oas", "gds", "dxf", "gbr", "svg", "tif")


@functools.cache
def _film():
    from mpfcad.film import Groove, PrismFilm

    curvature = np.r_[np.linspace(55, 64, 6), 80.0, 80.0]
    return PrismFilm(Groove(0.050, 0.025), 0.2, 2.0, "filled", curvature)


@functools.cache
def _mask():
    from mpfcad.film import read_process
    from mpfcad.mask import MaskRules, build_mask

    process = read_process(None, _film().groove)
    return build_mask(_film(), process, MaskRules("slot", 0.400, 0.010, 0.015), "fuzz")


@functools.cache
def written(suffix: str) -> tuple[bytes, ...]:
    """Return a small film or mask as a run writes it."""
    from mpfcad.cad import write_3mf, write_ply, write_step, write_stl
    from mpfcad.mask import write_mask

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"film.{suffix}"
        if suffix in MASKS:
            write_mask(_mask(), path)
        elif suffix == "step":
            write_step(_film(), path)
        else:
            {"stl": write_stl, "3mf": write_3mf, "ply": write_ply}[suffix](_film(), path, 0.1)
        data = path.read_bytes()
    return (model(data) if suffix == "3mf" else data,)


def model(package: bytes) -> bytes:
    """Return what is in a 3MF package: its checksum would keep a mutation from being read."""
    with zipfile.ZipFile(io.BytesIO(package)) as archive:
        return archive.read("3D/3dmodel.model")


def packed(path: Path) -> None:
    """Put a model into a 3MF package, in place."""
    data = path.read_bytes()
    if not data.startswith(b"PK"):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("[Content_Types].xml", _TYPES)
            archive.writestr("_rels/.rels", _RELATIONS)
            archive.writestr("3D/3dmodel.model", data)


_TYPES = (
    '<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/'
    'content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.'
    'relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.'
    '3dmanufacturing-3dmodel+xml"/></Types>'
)
_RELATIONS = (
    '<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/'
    'relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.'
    'microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)


def _judged(path: Path, check) -> None:
    """Read as `verify` does, where a file that does not read back is a gate."""
    from mpfcad.pipeline.run.file_check import FileFindings, judged

    found = FileFindings(foreign=True)
    with judged(found, "file", path):
        check()
    if found.gates:
        raise ExportError(found.gates[0].detail)


def _mask_file(path: Path) -> None:
    from mpfcad.mask import check_mask

    if path.suffix == ".oas":
        # Its checksum computed anew: what lies behind it is to be reached.
        data = path.read_bytes()
        path.write_bytes(data[:-4] + zlib.crc32(data[:-4]).to_bytes(4, "little"))
    _judged(path, lambda: check_mask(path, _mask()))


def _returned(path: Path) -> None:
    from mpfcad.boundary import guarded
    from mpfcad.mask.check.compare import compare_mask
    from mpfcad.mask.phototool import Phototool

    with guarded(path, "a mask file"):
        compare_mask(path, _mask(), Phototool())


def _cad_file(path: Path) -> None:
    from mpfcad.cad import check_3mf, check_ply, check_step, check_stl

    if path.suffix == ".3mf":
        packed(path)
    check = {
        ".step": check_step,
        ".stl": lambda p, f: check_stl(p, f, 0.1),
        ".3mf": check_3mf,
        ".ply": check_ply,
    }
    _judged(path, lambda: check[path.suffix](path, _film()))


def _record(path: Path) -> None:
    from mpfcad.pipeline.plan.restored import restore_plan
    from mpfcad.pipeline.run.verify import checked_record, read_record

    folder = path.with_suffix(".export")
    folder.mkdir(exist_ok=True)
    (folder / "curvature.csv").write_text(_CURVATURE)
    stored = read_record(path.replace(folder / "verification.json"))
    with checked_record(folder, stored):
        restore_plan(folder, stored["job"])


_CURVATURE = "groove,position_mm,curvature_per_mm\n" + "".join(
    f"{i},{(i + 0.5) * 0.05:.6f},60\n" for i in range(80)
)


@functools.cache
def _records() -> tuple[bytes, ...]:
    from mpfcad.export import canonical_json
    from mpfcad.job import read_job
    from mpfcad.pipeline.plan.plan import read_plan
    from mpfcad.pipeline.plan.restored import stored_job

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "job.toml"
        path.write_text(JOB)
        plan = read_plan(read_job(path), path)
        job = json.loads(canonical_json({**stored_job(plan), "trace": {}}))
        return (json.dumps({"schema": 1, "name": "a", "job": job}, indent=1).encode(),)


def _signature(path: Path) -> None:
    from mpfcad.export import MANIFEST
    from mpfcad.export.signature import check_signature

    folder = path.with_suffix(".export")
    folder.mkdir(exist_ok=True)
    (folder / MANIFEST).write_bytes(b"{}")
    with suppress(FileNotFoundError):
        path.replace(folder / f"{MANIFEST}.sig")
    public = folder.parent / "key.pub"
    public.write_text("ssh-ed25519 " + "A" * 68 + " maker\n")
    check_signature(folder, public)


_SIGNATURE = (
    b"-----BEGIN SSH SIGNATURE-----\n"
    b"U1NIU0lHAAAAAQAAADMAAAALc3NoLWVkMjU1MTkAAAAgHYHW0i1QdcEl2Z3dMrpZgjqSWjg7\n"
    b"-----END SSH SIGNATURE-----\n"
)


def readers() -> list[Reader]:
    """Return the readers of what a run wrote."""
    found = [
        Reader(
            f"mask-{suffix}",
            f".{suffix}",
            _mask_file,
            partial(written, suffix),
            native=True,
            apart=True,
        )
        for suffix in MASKS
    ]
    found += [
        Reader(
            f"returned-{suffix}",
            f".{suffix}",
            _returned,
            partial(written, suffix),
            native=True,
            apart=True,
        )
        for suffix in ("gds", "oas", "dxf", "gbr")
    ]
    found += [
        Reader(
            f"film-{suffix}",
            f".{suffix}",
            _cad_file,
            partial(written, suffix),
            native=True,
            apart=True,
        )
        for suffix in ("step", "stl", "3mf", "ply")
    ]
    return [
        *found,
        Reader("record", ".json", _record, _records, named="verification.json"),
        Reader("signature", ".sig", _signature, (_SIGNATURE,), named=".sig", costly=True),
    ]
