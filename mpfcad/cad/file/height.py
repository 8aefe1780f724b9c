"""The film's surface as a height map: z at points of a grid, as TIFF or as text for ray tracers.

`.tif` is one float32 image in mm, tiled and deflated, its top row at the largest y. `.dat` is the
grid sag file of OpticStudio: a line of counts and distances, then a line a point from the upper
left on, rows from left to right; derivatives 0 ask the reader to find them.
"""

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import refuse_above
from mpfcad.errors import ExportError, InputError
from mpfcad.units import um

#: Most points of a TIFF file (1 GB before deflating), and of a text file.
MOST_POINTS = {".tif": 250_000_000, ".dat": 1_000_000}
#: Fewest points each way that readers of text grids take.
LEAST_POINTS = 5
#: Rows and columns of a tile.
TILE = (64, 1024)
DEFLATE = 8
#: Largest error [mm] of a height: a float32 step at 4 mm and less.
HEIGHT_TOLERANCE = 2.5e-7


@dataclass(frozen=True)
class HeightGrid:
    """Where heights are taken: points from corner to corner, edges included.

    Attributes
    ----------
    size
        extent along x and y [mm]
    shape
        points along y and x
    height
        z [mm] over (x, y) [mm], any shapes that broadcast
    """

    size: tuple[float, float]
    shape: tuple[int, int]
    height: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]

    @property
    def step(self) -> tuple[float, float]:
        """Distance of neighbouring points along x and y [mm]."""
        return self.size[0] / (self.shape[1] - 1), self.size[1] / (self.shape[0] - 1)

    def blocks(self, tile: tuple[int, int]) -> Iterator[tuple[slice, slice, NDArray[np.float32]]]:
        """Yield rows, columns and heights [mm] there, a tile at a time; row 0 is the largest y."""
        ny, nx = self.shape
        for row in range(0, ny, tile[0]):
            rows = slice(row, min(row + tile[0], ny))
            y = self.size[1] * (1 - np.arange(rows.start, rows.stop) / (ny - 1))
            for column in range(0, nx, tile[1]):
                columns = slice(column, min(column + tile[1], nx))
                x = self.size[0] * (np.arange(columns.start, columns.stop) / (nx - 1))
                yield rows, columns, self.height(x[None, :], y[:, None]).astype(np.float32)


def build_height_grid(
    size: tuple[float, float],
    sample: tuple[float, float],
    height: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]],
) -> HeightGrid:
    """Return the grid of points at most `sample` [mm] apart along x and y."""
    nx, ny = (
        max(math.ceil(extent / apart - 1e-9) + 1, LEAST_POINTS)
        for extent, apart in zip(size, sample, strict=True)
    )
    return HeightGrid(size, (ny, nx), height)


def write_heights(grid: HeightGrid, path: Path, name: str) -> None:
    """Write the grid as `.tif` or `.dat`; same film, same bytes.

    Raises
    ------
    InputError
        when there are too many points.
    """
    path = Path(path)
    refuse_points(grid, path.name)
    part = path.with_name("." + path.name + ".part")
    try:
        (_write_tiff if path.suffix == ".tif" else _write_text)(grid, part, name)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def refuse_points(grid: HeightGrid, file: str, where: str = "") -> None:
    """Refuse a height map, by its file's name, of more points than such a file may have.

    Raises
    ------
    InputError
        that begins with `where` and says how far apart the points may be.
    """
    suffix = Path(file).suffix
    most = MOST_POINTS[suffix]
    (ny, nx), (dx, dy) = grid.shape, grid.step
    if nx * ny > most:
        wider = dy * nx * ny / most
        raise InputError(
            f"{where}{file}: {grid.size[0]:.6g} x {grid.size[1]:.6g} mm, a point each "
            f"{dx / um:.4g} x {dy / um:.4g} µm: {nx * ny / 1e6:.4g} million points: expected at "
            f"most {most / 1e6:g} million: cad.sample_along_um = {math.ceil(wider / um):g} fits"
        )


def _write_tiff(grid: HeightGrid, path: Path, name: str) -> None:
    import tifffile

    (ny, nx), (dx, dy) = grid.shape, grid.step
    stated = {
        "name": name,
        "value": "height over the underside",
        "unit": "mm",
        "spacing_across_mm": dx,
        "spacing_along_mm": dy,
        "first_row": "largest y",
        "first_column": "x = 0",
    }
    with tifffile.TiffWriter(path, bigtiff=True, byteorder="<") as file:
        file.write(
            _tiles(grid),
            shape=(ny, nx),
            dtype=np.float32,
            photometric="minisblack",
            tile=TILE,
            compression=DEFLATE,
            maxworkers=1,
            resolution=(10 / dx, 10 / dy),
            resolutionunit="CENTIMETER",
            description=json.dumps(stated),
            software=False,
            metadata=None,
        )


def _tiles(grid: HeightGrid) -> Iterator[NDArray[np.float32]]:
    """Yield the tiles, row by row of them; beyond the edges they hold zeros."""
    for _, _, inside in grid.blocks(TILE):
        tile = np.zeros(TILE, np.float32)
        tile[: inside.shape[0], : inside.shape[1]] = inside
        yield tile


def _write_text(grid: HeightGrid, path: Path, name: str) -> None:
    del name  # the format has no room for comments
    (ny, nx), (dx, dy) = grid.shape, grid.step
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write(f"{nx} {ny} {dx:.12g} {dy:.12g} 0 0 0\n")
        for _, _, heights in grid.blocks((1, nx)):
            file.write("".join(f"{z:.9g} 0 0 0 0\n" for z in heights[0].tolist()))


@dataclass(frozen=True)
class HeightCheck:
    """What a height map was found to hold.

    Attributes
    ----------
    shape
        points along y and x
    height_error_max
        largest distance [mm] of a height from the film's surface
    """

    shape: tuple[int, int]
    height_error_max: float


def check_heights(path: Path, grid: HeightGrid) -> HeightCheck:
    """Return what a height map holds, read with Pillow or as text, once it is found to be the film.

    Raises
    ------
    ExportError
        when it has another size or spacing, or a height is off by more than float32 forces.
    """
    path = Path(path)
    found, step = (_read_tiff if path.suffix == ".tif" else _read_text)(path)
    if found.shape != grid.shape or not np.allclose(step, grid.step, rtol=1e-6, atol=0):
        raise ExportError(
            f"{path.name}: {found.shape} points, {step} mm apart: "
            f"expected {grid.shape}, {grid.step}"
        )
    error = 0.0
    for rows, columns, wanted in grid.blocks(TILE):
        error = max(error, float(np.abs(found[rows, columns] - wanted).max()))
    refuse_above(path, "height error [mm]", error, HEIGHT_TOLERANCE)
    return HeightCheck(grid.shape, error)


def _read_tiff(path: Path) -> tuple[NDArray[np.float32], tuple[float, float]]:
    from PIL import Image
    from PIL.TiffImagePlugin import TiffImageFile

    limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, MOST_POINTS[".tif"]
    try:
        with TiffImageFile(path) as image:
            dots = [float(image.tag_v2[tag]) for tag in (282, 283)]
            found = np.asarray(image)
    except (OSError, ValueError, TypeError) as error:
        raise ExportError(f"{path.name}: Pillow cannot read this file: {error}") from error
    finally:
        Image.MAX_IMAGE_PIXELS = limit
    if found.dtype != np.float32:
        raise ExportError(f"{path.name}: {found.dtype} numbers: expected float32")
    return found, (10 / dots[0], 10 / dots[1])


def _read_text(path: Path) -> tuple[NDArray[np.float64], tuple[float, float]]:
    try:
        lines = path.read_text("ascii").splitlines()
        nx, ny, dx, dy, unit, *_ = lines[0].split()
        heights = np.array([float(line.partition(" ")[0]) for line in lines[1:]])
        found = heights.reshape(int(ny), int(nx))
    except (OSError, ValueError, IndexError) as error:
        raise ExportError(f"{path.name}: not a grid sag file: {error}") from error
    if unit != "0":
        raise ExportError(f"{path.name}: unit flag {unit}: expected 0, mm")
    return found, (float(dx), float(dy))
