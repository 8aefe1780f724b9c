"""A stack in bands, lowered to the scenes that are traced."""

from typing import TYPE_CHECKING

import numpy as np

from mpfcad.backlight.lower import lower_stack
from mpfcad.backlight.stack import Stack
from mpfcad.optics.element import Element
from mpfcad.optics.library.piece import Library
from mpfcad.optics.library.top import CellTops
from mpfcad.optics.solid.mesh import FilmMesh

if TYPE_CHECKING:
    from mpfcad.optics.spectral.engine import Spectral


def lower_bands(
    stack: Stack,
    mesh: FilmMesh | Library | CellTops | None,
    offset: float,
    elements: list[Element],
) -> "Spectral | None":
    """Return what traces a stack's bands; None where it has none.

    `mesh` and `offset` as of `lower_stack`, which gave `elements`.
    """
    from mpfcad.optics.scene import build_scenes
    from mpfcad.optics.spectral.engine import Band, build_spectral
    from mpfcad.optics.spectral.envelope import same_geometry

    bands = stack.bands
    if bands is None:
        return None
    variants = [
        same_geometry(lower_stack(stack.at_band(i), mesh, offset), elements)
        for i in range(bands.count)
    ]
    emission = [bands.photons(one) for one in bands.emission.values()]
    band = Band(
        bands.source_power,
        bands.channel_colour,
        bands.mean_wavelength,
        np.array(emission).reshape(-1, bands.count),
        np.array([stack[f"{name}.yield"] for name in bands.emission]),
    )
    scenes = build_scenes(variants, polarised=stack.polarised)
    return build_spectral(scenes, band, joint=not bands.separate)
