"""Readers of layers, materials and light sources of every kind, lowered as a trace has them."""

import functools
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from .instrument import _rays
from .kind import Reader
from .written import JOB, written

_POLARISED = b"""extends = "thesis-32in-mpf"
layers = [
    "clear_plate", "bottom_sheet", "film",
    { kind = "retarder", name = "wave", axis_deg = 45, retardation_nm = 137.5 },
    { kind = "polariser", name = "linear", axis_deg = 10, transmission_along = 0.9 },
    { kind = "reflective_polariser", name = "dbef", transmission_along = 0.90, transmission_across = 0.03, reflection_along = 0.09, reflection_across = 0.95 },
]
[light]
polarised = true
[value]
sheet_depolarisation = 0.5
"""  # noqa: E501
_MUELLER = b"""extends = "thesis-32in-mpf"
layers = [
    "clear_plate", "film", "top_sheet",
    { kind = "mueller", name = "m", axis_deg = 5, m00 = 0.5, m01 = 0.5, m02 = 0, m03 = 0, m10 = 0.5, m11 = 0.5, m12 = 0, m13 = 0, m20 = 0, m21 = 0, m22 = 0, m23 = 0, m30 = 0, m31 = 0, m32 = 0, m33 = 0 },
]
[light]
polarised = true
"""  # noqa: E501
_FILMS = b"""extends = "thesis-32in-mpf"
layers = [
    "clear_plate",
    { kind = "lens", sag_um = 12, pitch_um = 60, base_um = 150, index = 1.5 },
    "film",
    { kind = "composite", name = "dop", bond_um = 3, rotation_deg = 90, cover_um = 100 },
    { kind = "composite", name = "pop", bond_um = 2, upper_pitch_um = 40, upper_depth_um = 20 },
    { kind = "sheet", name = "dop_top", sigma = 0.2, index = 1, transmission = 1 },
    { kind = "bef", name = "crossed", pitch_um = 50, depth_um = 25, rotation_deg = 90 },
    { kind = "sheet", name = "wide", sigma = 0.2, sigma_across = 0.1, axis_deg = 10, wide_sigma = 0.5, wide_share = 0.2 },
]
"""  # noqa: E501
_MATERIALS = b"""extends = "thesis-32in-mpf"
[value]
light_wavelength_nm = 550
film_index = { cauchy = [1.544, 0.0041], tag = "assumed", source = "usual" }
film_absorption_per_mm = { table_nm = [[400, 0.3], [550, 0.05], [700, 0.03]], tag = "assumed" }
film_base_index = { sellmeier = [1.2, 0.01, 0.1, 90.0] }
film_base_thickness_um = { value = 125, sigma = 2 }
film_base_absorption_per_mm = 0.02
film_primer_index = 1.58
film_primer_thickness_um = { value = 1, range = [0.5, 1.5] }
film_roughness = 0.02
plate_index = { table_nm = [[400, 1.50], [700, 1.48]] }
reflector_reflectance = { table_nm = [[400, 0.90], [700, 0.98]] }
sheet_transmission = { table_nm = [[400, 0.97], [700, 0.99]] }
"""
_BOARD = b"""extends = "mini-led-4mm"
layers = ["clear_plate", "bottom_sheet", "top_sheet"]
[source]
kind = "leds"
lattice = "hexagonal"
emission = "cosine"
cup = "round"
repeat = [2, 1]
dead = [1]
seed = 3
[value]
led_half_angle_deg = 60
led_flux_spread = 0.05
led_position_error_mm = 0.1
led_hole_radius_mm = 1.0
led_hole_reflectance = 0.5
led_cup_height_mm = 0.8
led_cup_radius_mm = 1.0
led_cup_rim_radius_mm = 1.6
"""
_PYRAMIDS = JOB.encode().replace(
    b"[map]\ncurvature_per_mm = 60.0", b'[map]\ncurvature_per_mm = 60.0\n[film]\ncell = "pyramid"'
)
_PRINTED = b"""name = "a"
[map]
series_per_mm = [[64.0, 2.2], [2.2, 0.0]]
[film]
cell = "pyramid"
[stack]
preset = "mini-led-4mm"
[process]
solids_fraction = 0.2
[mask]
mesh = "120-40"
period_um = 320.0
viewing_distance_mm = 750.0
formats = ["oas"]
"""
_POSITIONS = b"x_mm,y_mm,flux_factor\n0,0,1\n1.5,0.5,0.9\n-1.5,-0.5,1.1\n"
_UPRIGHT = "x_um,z_um\n" + "".join(
    f"{x:.2f},{25 - abs(x % 50 - 25):.4f}\n" for x in np.arange(0, 100, 2.5)
)


@functools.cache
def _film() -> Path:
    """Return the mesh of a small film, which lies there as long as this process."""
    folder = tempfile.mkdtemp()
    path = Path(folder) / "film.stl"
    path.write_bytes(written("stl")[0])
    return path


def _lowered(path: Path) -> None:
    from mpfcad.backlight import read_stack
    from mpfcad.measure import light_film

    stack = read_stack(path)
    if not stack.needs_prism:
        light_film(stack, _film() if stack.has_slot else None)


def _planned(path: Path) -> None:
    from mpfcad.job import read_job
    from mpfcad.pipeline.plan.plan import read_plan

    read_plan(read_job(path), path)


def _positions(path: Path) -> None:
    from mpfcad.backlight.source.lattice import folder_text, read_positions

    where = f"stack.toml: source.positions: {path.name}"
    read_positions(where, folder_text(where, path.parent, path.name))


def _coupons(path: Path) -> None:
    from mpfcad.cli.measure.calibrate import _read_coupons

    _read_coupons([], [], path)


def _upright(path: Path) -> None:
    from mpfcad.film import Groove, ReadingOption, read_stylus_trace

    read_stylus_trace(path, Groove(0.05, 0.025), 2, ReadingOption(upright=True))


@functools.cache
def _pieces():
    from mpfcad.film import Groove
    from mpfcad.film.field.library import PieceLibrary

    level, chosen = np.array([55.0, 60.0]), np.array([[0, 1], [1, 0], [1, 1]])
    return PieceLibrary(Groove(0.05, 0.025), 0.2, 0.5, level, chosen, level[chosen])


def _placement(path: Path) -> None:
    from mpfcad.cad.file.placement import check_placement

    check_placement(path, _pieces())


def _listed() -> tuple[bytes, ...]:
    from mpfcad.cad.file.placement import write_placement

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.csv"
        write_placement(_pieces(), path)
        return (path.read_bytes(),)


def _all_rays(path: Path) -> None:
    from mpfcad.backlight.source.ray_file import read_rays

    read_rays(path.name, path)


def _as_exported(suffix: str) -> tuple[bytes, ...]:
    """Return a ray file as `mpfcad rays` writes it."""
    from mpfcad.backlight.source.ray_write import About, write_ray_file

    table = np.frombuffer(_rays(".ray")[44:], "<f4").reshape(-1, 7)

    def collect(keep) -> float:
        keep(table)
        return 2.0

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{suffix}"
        write_ray_file(path, suffix, About("a", "mpfcad", "b"), collect)
        return (path.read_bytes(),)


def readers() -> list[Reader]:
    """Return the readers of layers and light sources."""
    return [
        Reader("layers-polarised", ".toml", _lowered, (_POLARISED, _MUELLER)),
        Reader("layers-films", ".toml", _lowered, (_FILMS,)),
        Reader("materials", ".toml", _lowered, (_MATERIALS,)),
        Reader("board", ".toml", _lowered, (_BOARD,)),
        Reader("pyramids", ".toml", _planned, (_PYRAMIDS, _PRINTED), costly=True),
        Reader("positions", ".csv", _positions, (_POSITIONS,)),
        Reader("coupons", ".csv", _coupons, (b"file,aperture_ratio\na.csv,0.1\nb.csv,0.2\n",)),
        Reader("stylus-upright", ".csv", _upright, (_UPRIGHT.encode(),), costly=True),
        Reader("placement", ".csv", _placement, _listed),
        *(Reader(f"rays-out{form}", form, _all_rays, partial(_as_exported, form))
          for form in (".tm25ray", ".dat", ".ray")),
    ]  # fmt: skip
