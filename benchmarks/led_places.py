"""What a path costs over the number of places of a film that is a library of pieces.

    python benchmarks/led_places.py [--blocks N] [--rounds N] [--most EXPONENT]

One board of LEDs lies under two crossed films of 64 curvatures. The films repeat over cells of 4,
12 and 49 mm, or are panels whose pieces do not repeat, of 10⁴ … 10⁸. Which piece stands where is
drawn evenly, so all films are alike but for their number of places; drawn so, neighbours differ as
they do in no real map, and a look-up is never near the last one. The scenes are traced by turns in
one run, on one thread. A panel of 10⁸ places takes 0.8 GB while it is built, 0.2 GB in the scene.
"""

import argparse

import numpy as np
from tracer.race import spent

from mpfcad.cad.file.library import piece_section
from mpfcad.film import Groove, build_library
from mpfcad.optics.cavity.board import Board
from mpfcad.optics.cavity.emission import Emission
from mpfcad.optics.element import LibraryFilm, Sheet, Slab
from mpfcad.optics.forward.connection import CellMeter
from mpfcad.optics.forward.engine import BLOCK, trace_forward
from mpfcad.optics.library.piece import Library
from mpfcad.optics.scene import build_scene

GROOVE, PIECE, PITCH, CURVATURES = Groove(0.05, 0.025), 0.5, 12.0, 64
#: Sides of cells [mm].
CELLS = (4.0, 12.0, 49.0)


def shapes(most: int) -> dict[str, tuple[int, int]]:
    """Return places across and along of each film, by what it is."""
    found = {
        f"cell {side:g} mm": (round(side / GROOVE.pitch), round(side / PIECE)) for side in CELLS
    }
    for exponent in range(4, most + 1):
        across = round(np.sqrt(10.0 ** (exponent + 1)))
        found[f"panel 1e{exponent}"] = across, round(10**exponent / across)
    return found


def build(shape: tuple[int, int], sections: tuple[np.ndarray, ...]):
    """Return the scene of a film with so many places."""
    chosen = np.random.default_rng(7).integers(0, CURVATURES, shape)
    library = Library(GROOVE.pitch, PIECE, sections, chosen)
    board = Board(
        6.0, (PITCH, PITCH), np.zeros((1, 2)), np.ones(1), (2.8, 2.8), 0.7, 25.0, 0.6,
        Emission.cosine_power(1.0), 0.95, 0.3,
    )  # fmt: skip
    return build_scene([
        board, Slab(1.49, 1.5), Sheet(0.36, 1.49, 0.98), LibraryFilm(library, 1.55),
        LibraryFilm(library, 1.55, rotation=np.pi / 2), Sheet(0.35, 1.49, 0.98),
    ])  # fmt: skip


def trace(scene, meter: CellMeter, blocks: int, seed: int):
    """Return the tally of paths from the LEDs."""
    return trace_forward(scene, meter, blocks, seed=seed)


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--blocks", type=int, default=24, help="of 4096 paths, each turn")
    options.add_argument("--rounds", type=int, default=7, help="turns")
    options.add_argument("--most", type=int, default=7, help="pieces of the largest panel, as 10^N")
    chosen = options.parse_args()
    wanted = np.linspace(55.0, 78.0, CURVATURES)[:, None]
    pieces = build_library(GROOVE, 0.15, PIECE, wanted, CURVATURES)
    sections = tuple(piece_section(pieces, i, np.radians(1.0)) for i in range(CURVATURES))
    meter = CellMeter(np.sin(np.radians(1.0)), PITCH, PITCH, 24)
    scenes = {name: build(shape, sections) for name, shape in shapes(chosen.most).items()}
    times: dict[str, list[float]] = {name: [] for name in scenes}
    work: dict[str, float] = {}
    for turn in range(chosen.rounds + 1):
        for name, scene in scenes.items():
            tally, cpu = spent(trace, scene, meter, chosen.blocks, turn + 1)
            work[name] = tally.passed / tally.paths
            if turn:  # the first one compiles
                times[name].append(cpu / (chosen.blocks * BLOCK) * 1e9)
    first = next(iter(times))
    print("film  places  passages a path  least ns a path  over the first: least, median")
    for name, shape in shapes(chosen.most).items():
        pairs = np.array(times[name]) / np.array(times[first])
        print(
            f"{name}  {shape[0] * shape[1]:.3g}  {work[name]:.2f}  {min(times[name]):.0f}  "
            f"{min(times[name]) / min(times[first]):.3f}  {np.median(pairs):.3f}"
        )


if __name__ == "__main__":
    main()
