"""`mpfcad bsdf`: makes the BSDF table of a film mesh; reads, checks, shows and converts tables."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mpfcad.cli.character import print_json
from mpfcad.cli.option import Json, Seed, Threads

if TYPE_CHECKING:
    from collections.abc import Callable

    from mpfcad.cli.terminal import Terminal
    from mpfcad.optics.bsdf.basis import AngleBasis
    from mpfcad.optics.bsdf.table import BsdfTable
    from mpfcad.optics.bsdf_film import FilmBsdf

_MOST_RINGS = 30


def command(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE…",
            help="A film (.stl, .3mf, .ply, .obj, .step), or a table (.xml, .csv, .astm, one or "
            "more .bsdf) to check.",
            show_default=False,
        ),
    ],
    index: Annotated[
        float, typer.Option("--index", min=1.0, max=4.0, help="Refractive index of the film.")
    ] = 1.55,
    basis: Annotated[
        str | None,
        typer.Option(
            "--basis",
            metavar="NAME",
            help="klems-full, klems-half, klems-quarter or a number of rings "
            f"(2 … {_MOST_RINGS}) [default: klems-full for a mesh, its own for a table].",
        ),
    ] = None,
    rays: Annotated[
        int,
        typer.Option("--rays", min=100, max=100_000_000, help="Rays per incidence bin and side."),
    ] = 20_000,
    seed: Seed = 1,
    reciprocal: Annotated[
        bool,
        typer.Option(
            "--reciprocal", help="The table is reciprocal: check it and mend small differences."
        ),
    ] = False,
    symmetric: Annotated[
        bool, typer.Option("--symmetric", help="Take a missing side as the other one.")
    ] = False,
    reflection: Annotated[
        str | None,
        typer.Option(
            "--reflection", metavar="R", help="Reflectance of a missing side: 0 … 1, or lossless."
        ),
    ] = None,
    transmission: Annotated[
        float | None,
        typer.Option(
            "--transmission", min=0.0, max=1.0, help="Transmittance where the file holds none."
        ),
    ] = None,
    normalise: Annotated[
        bool,
        typer.Option(
            "--normalise",
            help="Divide rows by sums of up to 5 % above 1, instead of refusing them.",
        ),
    ] = False,
    rotation: Annotated[
        str | None,
        typer.Option(
            "--rotation",
            metavar="WORDS",
            help="Meaning of Zemax's sample rotations: '+y counterclockwise', …",
        ),
    ] = None,
    format: Annotated[
        str | None,
        typer.Option(
            "--format", help="Formats to write: klems, csv, zemax [default: klems for a mesh]."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="DIR", help="Folder of the files that are written [default: here]."
        ),
    ] = None,
    page: Annotated[bool, typer.Option("--page", help="Write a page of plots too.")] = False,
    threads: Threads = None,
    json: Json = False,
) -> int:
    """Make the BSDF table of a film mesh, or check and convert a table."""
    from mpfcad.cli.option import formats
    from mpfcad.errors import InputError
    from mpfcad.optics.bsdf.file import FORMATS, bsdf_texts, read_bsdf, write_texts
    from mpfcad.optics.bsdf.missing import NONE, WHOLE, Taken
    from mpfcad.optics.bsdf.rebin import rebin
    from mpfcad.optics.solid.file import SUFFIXES

    of_mesh = files[0].suffix.lower() in SUFFIXES
    if of_mesh and len(files) > 1:
        raise InputError(f"{files[1]}: several files: expected for Zemax .bsdf only")
    chosen = formats(format, FORMATS) if format else ("klems",) * of_mesh
    made = None
    if of_mesh:
        made = _trace(files[0], index, _basis(basis or "klems-full"), rays, seed, threads)
        table = made.table
    else:
        taken = Taken(symmetric, _reflection(reflection), transmission, reciprocal)
        writes = chosen or basis or page
        table = read_bsdf(
            files, taken=taken, needed=WHOLE if writes else NONE, normalise=normalise,
            rotation=rotation,
        )  # fmt: skip
        if basis:
            table = rebin(table, _basis(basis))
    stem = files[0].stem
    texts: dict[str, str] = {}
    for form in chosen:
        texts |= bsdf_texts(table, stem, form)
    if page:
        from mpfcad.report.page.bsdf_page import bsdf_page

        texts[f"{stem}-bsdf.html"] = bsdf_page(table)
    folder = out or Path()
    for name in texts:
        if any((folder / name).resolve() == file.resolve() for file in files):
            raise InputError(f"{folder / name}: is what is read: give another --out")
    written = write_texts(folder, texts) if texts else []
    figures = _figures(table, made) | {"written": [str(path) for path in written]}
    if json:
        print_json(figures)
    else:
        _print(figures)
    return 0


def _reflection(text: str | None) -> float | str | None:
    """Return what is said of a missing side's reflection."""
    from mpfcad.errors import InputError
    from mpfcad.optics.bsdf.missing import LOSSLESS

    if text is None or text == LOSSLESS:
        return text
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 1:
        raise InputError(f"--reflection: {text}: expected 0 … 1, or {LOSSLESS}")
    return value


def _basis(name: str) -> "AngleBasis":
    from mpfcad.errors import InputError
    from mpfcad.optics.bsdf.basis import even_basis, klems_basis

    if name in ("klems-full", "klems-half", "klems-quarter"):
        return klems_basis("LBNL/Klems " + name.removeprefix("klems-"))
    if name.isdecimal() and 2 <= int(name) <= _MOST_RINGS:
        return even_basis(int(name))
    raise InputError(
        f"--basis: {name}: expected klems-full, klems-half, klems-quarter or 2 … {_MOST_RINGS}"
    )


def _trace(
    path: Path, index: float, basis: "AngleBasis", rays: int, seed: int, threads: int | None
) -> "FilmBsdf":
    import os

    from mpfcad.cli.terminal import Terminal
    from mpfcad.optics.bsdf_film import trace_film_bsdf
    from mpfcad.optics.solid.mesh import read_film_mesh

    mesh = read_film_mesh(path)
    with Terminal() as terminal:
        terminal.note(mesh.note)
        terminal.stage(f"tracing {2 * basis.count * rays / 1e6:.1f} million rays")
        return trace_film_bsdf(
            mesh, index, basis, name=path.stem, rays=rays, seed=seed,
            threads=threads or os.cpu_count() or 1, after_bin=_progress(terminal),
        )  # fmt: skip


def _progress(terminal: "Terminal") -> "Callable[[int, int], None]":
    def show(done: int, count: int) -> None:
        terminal.count(done, count, f"{done} of {count} incidence bins")

    return show


def _figures(table: "BsdfTable", made: "FilmBsdf | None") -> dict[str, Any]:
    """Return what is printed: energy a ring of incidence, the worst bin of it, reciprocity."""
    import numpy as np

    from mpfcad.optics.bsdf.table import SIDES

    energy = table.energy
    ring = np.arange(energy.shape[2]) if table.isotropic else table.basis.ring
    rows = []
    for side, name in enumerate(SIDES):
        for r, polar in enumerate(np.degrees(table.basis.polar)):
            mine = energy[:, side, ring == r]
            rows.append(
                {
                    "side": name,
                    "incidence_deg": round(float(polar), 6),
                    "transmittance": _known(table, 0, side, float(mine[0].mean())),
                    "reflectance": _known(table, 1, side, float(mine[1].mean())),
                    "most": float(mine.sum(axis=0).max()),
                }
            )
    figures = {
        "schema": 1,
        "name": table.name,
        "basis": table.basis.name,
        "bins": table.basis.count,
        "isotropic": table.isotropic,
        "energy": rows,
        "lambertian_transmittance": _hemispherical(table, 0),
        "lambertian_reflectance": _hemispherical(table, 1),
        "reciprocity_error": None if table.unknown else table.reciprocity_error,
        "notes": list(table.note),
    }
    if made is not None:
        figures["trace"] = {
            "rays_per_bin": made.rays,
            "transmittance_standard_error_max": float(made.energy_error.max()),
            "misplaced_share": made.noise,
            "reciprocity_error_as_traced": made.traced.reciprocity_error,
        }
    return figures


def _known(table: "BsdfTable", way: int, side: int, value: float) -> float | None:
    """Return a figure, or None where the file says nothing."""
    return None if (way, side) in table.unknown else value


def _hemispherical(table: "BsdfTable", way: int) -> dict[str, float | None]:
    from mpfcad.optics.bsdf.table import SIDES

    share = table.hemispherical[way].tolist()
    return {name: _known(table, way, side, share[side]) for side, name in enumerate(SIDES)}


def _shown(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.4f}"


def _print(figures: dict[str, Any]) -> None:
    kind = "isotropic" if figures["isotropic"] else "anisotropic"
    print(f"{figures['name']}: {figures['basis']}, {figures['bins']} bins, {kind}")
    print("side   incidence_deg  transmittance  reflectance  most")
    for row in figures["energy"]:
        print(
            f"{row['side']:<7}{row['incidence_deg']:>13.4g}{_shown(row['transmittance']):>15}"
            f"{_shown(row['reflectance']):>13}  {row['most']:.4f}"
        )
    for side, value in figures["lambertian_transmittance"].items():
        back = figures["lambertian_reflectance"][side]
        print(
            f"Lambertian light from {side}: transmittance {_shown(value)}, "
            f"reflectance {_shown(back)}"
        )
    error = figures["reciprocity_error"]
    print(f"reciprocity error {'unknown' if error is None else f'{error:.2e}'}")
    if "trace" in figures:
        trace = figures["trace"]
        print(
            f"traced with {trace['rays_per_bin']} rays a bin: transmittance ± "
            f"{trace['transmittance_standard_error_max']:.1e}, light in wrong bins "
            f"{trace['misplaced_share']:.1e}, reciprocity error as traced "
            f"{trace['reciprocity_error_as_traced']:.1e}"
        )
    for note in figures["notes"]:
        print(f"note: {note}")
    for path in figures["written"]:
        print(path)
