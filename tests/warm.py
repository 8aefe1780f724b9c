"""Compiles what most tests trace with, half of it in each of two processes at once.

`python tests/warm.py 0` and `1`: each kernel is compiled for all scenes by one block of any.
"""

import sys

import numpy as np
from harness import dish_mesh, pass_layers, rays, through

from mpfcad.optics.cavity.board import Board
from mpfcad.optics.cavity.emission import Emission
from mpfcad.optics.element import Sheet
from mpfcad.optics.engine import compile_tracer, trace
from mpfcad.optics.forward.connection import CellMeter
from mpfcad.optics.forward.engine import trace_forward
from mpfcad.optics.scene import build_scene, build_scenes
from mpfcad.optics.score.columns import Columns
from mpfcad.optics.score.engine import trace_slopes
from mpfcad.optics.source import EYE, Source
from mpfcad.optics.spectral.engine import Band, build_spectral, trace_luminance

METER = Source(EYE, [0.0], 0.0)
SHEET = Sheet(0.3, 1.5, 1.0)


def scores() -> None:
    scene = build_scene([SHEET])
    trace_slopes(scene, METER, 1, np.zeros((1, len(Columns.of(scene).known))))


def polarised() -> None:
    trace(build_scene([SHEET], polarised=True), METER, 1)


def passages() -> None:
    pass_layers(build_scene([SHEET]), True, 1, np.empty((1, 4)))
    through(dish_mesh(), rays(1, up=True), up=True)


def leds() -> None:
    board = Board(
        8.0, (12.0, 12.0), np.zeros((1, 2)), np.ones(1), (3.0, 3.0), 0.0, 100.0, 0.5,
        Emission.cosine_power(1.0), 0.95, 0.3,
    )  # fmt: skip
    trace_forward(build_scene([board, SHEET]), CellMeter(0.05, 12.0, 12.0, 4), 1)


def bands() -> None:
    band = Band(np.ones(1), np.ones((1, 3)), np.array([550.0]), np.zeros((0, 1)), np.zeros(0))
    trace_luminance(build_spectral(build_scenes([[SHEET]]), band, joint=True), METER, 1)


PARTS = ((compile_tracer, polarised, passages), (leds, bands, scores))

if __name__ == "__main__":
    for compiles in PARTS[int(sys.argv[1])]:
        compiles()
