"""Readers of what instruments write: lamps, ray files, images, curves, areal maps."""

import functools
import io
import runpy
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from .kind import Reader
from .written import model, packed, written

IES = (
    "IESNA:LM-63-2002\n[TEST] a\n[MANUFAC] b\nTILT=NONE\n1 1000 1 7 1 1 2 -0.003 -0.003 0\n"
    "1 1 10\n0 15 30 45 60 75 90\n0\n100 93 75 50 25 7 0\n"
)
LDT = "\n".join(
    ["maker", "1", "1", "1", "0", "7", "15", "1", "led", "1", "f", "today", "10", "0", "5", "0",
     "0", "0", "0", "0", "0", "100", "100", "1", "0", "1", "1", "LED", "1000", "3000", "80", "10",
     *["0"] * 10, "0", "0", "15", "30", "45", "60", "75", "90",
     "100", "93", "75", "50", "25", "7", "0"]
)  # fmt: skip


def _emission(path: Path) -> None:
    from mpfcad.backlight.source.emission import read_emission

    read_emission("stack.toml: emission", path.parent, path.name)


def _image(path: Path) -> None:
    from mpfcad.measure.observed import Photo, curve_of_image, read_image

    curve_of_image(read_image(path, Photo(pixel=0.1)))


def _curve(path: Path) -> None:
    from mpfcad.measure.observed.curve import read_curve
    from mpfcad.measure.observed.image import is_image

    if is_image(path):
        _image(path)
    else:
        read_curve(path)


def _areal(path: Path) -> None:
    from mpfcad.film import Groove
    from mpfcad.film.stylus.file.reading import read_stylus_trace

    read_stylus_trace(path, Groove(0.05, 0.025))


def _solid(path: Path) -> None:
    from mpfcad.optics.solid.mesh import read_film_mesh

    read_film_mesh(path)


def _step_solids(path: Path) -> None:
    """Read as the process does that reads STEP files for the others."""
    from mpfcad.boundary import guarded
    from mpfcad.optics.solid.format.step import read_solids

    with guarded(path, "a STEP file"):
        read_solids(path, path.read_bytes())


def _library(path: Path) -> None:
    from mpfcad.optics.library.file import is_library_file, read_library

    packed(path)
    if is_library_file(path):
        read_library(path)
    else:
        _solid(path)


def _rays(form: str) -> bytes:
    rng = np.random.default_rng(8)
    cosine, turn = rng.random(60) ** (1 / 3), rng.random(60) * 2 * np.pi
    sine = np.sqrt(1 - cosine**2)
    direction = np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=1)
    table = np.concatenate([np.zeros((60, 3)), direction, np.full((60, 1), 0.5)], axis=1)
    head = bytearray({".tm25ray": 36288, ".dat": 208, ".ray": 44}[form])
    if form == ".tm25ray":
        head[:4] = b"TM25"
        head[20:28] = np.array([60], "<u8").tobytes()
        head[256:288] = np.array([1, 1, 1, 0, 0, 0, 0, 0], "<i4").tobytes()
    elif form == ".dat":
        head[:8] = np.array([1010, 60], "<u4").tobytes()
    else:
        head[:4] = b"LTRF"
    return bytes(head) + table.astype("<f4").tobytes()


@functools.cache
def _picture(suffix: str) -> tuple[bytes, ...]:
    counts = np.arange(24 * 20, dtype=np.uint16).reshape(20, 24) + 100
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{suffix}"
        if suffix == ".tif":
            import tifffile

            tifffile.imwrite(path, counts)
        elif suffix == ".fits":
            from astropy.io import fits

            fits.PrimaryHDU(counts.astype(np.int32)).writeto(path)
        else:
            import OpenEXR

            header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
            OpenEXR.File(header, {"Y": counts.astype(np.float32)}).write(str(path))
        return (path.read_bytes(),)


def _text_table(columns: int) -> bytes:
    file = io.StringIO()
    names = ["position mm", "luminance", "error", *"abcdefghijklmnopqrstuvwxyz"][:columns]
    file.write(",".join(names) + "\n")
    for i in range(20):
        file.write(",".join(f"{(i + 1) * (j + 1) * 0.5:.3f}" for j in range(columns)) + "\n")
    return file.getvalue().encode()


def _map(suffix: str) -> tuple[bytes, ...]:
    # Found alike by `pytest` and by `python -m tests.fuzz`.
    writer = Path(__file__).parents[1] / "film" / "areal_file.py"
    write_map = runpy.run_path(str(writer))["write_map"]
    x = np.arange(40) * 0.0025
    height = np.repeat((0.025 * (np.abs(x % 0.05 - 0.025)) / 0.025)[:, None], 8, axis=1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{suffix}"
        write_map(path, height, 0.0025)
        return (path.read_bytes(),)


def _step() -> tuple[bytes, ...]:
    return written("step")


def _pieces() -> tuple[bytes, ...]:
    """Return a 3MF of a few placed copies of groove pieces."""
    from mpfcad.cad.file.library import write_library
    from mpfcad.film import Groove
    from mpfcad.film.field.library import PieceLibrary

    level, chosen = np.array([55.0, 60.0]), np.array([[0, 1], [1, 0], [1, 1]])
    library = PieceLibrary(Groove(0.05, 0.025), 0.2, 0.5, level, chosen, level[chosen])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.3mf"
        write_library(library, path, 2.0)
        return (model(path.read_bytes()),)


def readers() -> list[Reader]:
    """Return the readers of what instruments write."""
    found = [
        Reader("ies", ".ies", _emission, (IES.encode(),)),
        Reader("ldt", ".ldt", _emission, (LDT.encode(),)),
        Reader("emission-csv", ".csv", _emission, (b"angle_deg,intensity\n0,9\n45,5\n90,0\n",)),
        *(Reader(f"rays{form}", form, _emission, (_rays(form),))
          for form in (".tm25ray", ".dat", ".ray")),
        *(Reader(f"image{form}", form, _image, partial(_picture, form), costly=True)
          for form in (".tif", ".fits")),
        Reader("image.exr", ".exr", _image, partial(_picture, ".exr"), native=True),
        Reader("curve", ".csv", _curve, (_text_table(2), _text_table(3), _text_table(20))),
        *(Reader(f"areal{form}", form, _areal, partial(_map, form), costly=True)
          for form in (".x3p", ".sdf", ".gwy")),
        Reader("step", ".step", _step_solids, _step, native=True, apart=True),
        Reader("library-3mf", ".3mf", _library, _pieces, native=True),
    ]  # fmt: skip
    return found
