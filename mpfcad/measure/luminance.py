"""Normal luminance over the central lamp pitch, traced from a mesh on disk."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.stack import Stack
from mpfcad.errors import TraceError
from mpfcad.measure.contrast import Estimate, HarmonicFit, contrast_of_harmonics, fit_harmonics

#: Points over the pitch: 0 and 1 above lamps, 0.5 between (Hsieh, MPF thesis).
POINTS = 33
_LEAST_BLOCKS = 16
_ENERGY_BLOCKS = 256


@dataclass(frozen=True, eq=False)
class LuminanceResult:
    """Luminance over a lamp pitch and what follows from it.

    Attributes
    ----------
    position_pitch
        (33,) float64, in lamp pitches from a lamp's axis
    luminance, standard_error
        (33,) float64 [cd/m²], each point averaged over the meter's spot
    fit
        the Fourier series through them
    contrast, mean_luminance
        lamp-Mura contrast; mean [cd/m²] over the pitch
    energy
        shares of the lamps' light from a forward trace: in = 1, out, absorbed (and by element),
        lost
    paths
        backward paths traced
    accelerator
        how the meshes were traced: `chain`, `bvh`, or each way that was taken
    """

    position_pitch: NDArray[np.float64]
    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    fit: HarmonicFit
    contrast: Estimate
    mean_luminance: Estimate
    energy: dict[str, object]
    paths: int
    accelerator: str


def luminance_over_pitch(
    stack: Stack,
    mesh_path: Path | None,
    *,
    offset: float = 0.0,
    seed: int = 1,
    half_width_goal: float = 0.002,
    path_limit: int = 100_000_000,
    threads: int = 1,
    progress: Callable[[int, float], None] | None = None,
) -> LuminanceResult:
    """Return the luminance over one lamp pitch of a film mesh, read from disk, in a stack.

    `mesh_path` is None for a stack without film, that of a BSDF table in its place.

    Traces rounds of paths until the 95 % half-width of the contrast reaches `half_width_goal` or
    `path_limit` paths are traced. `offset` [mm] is the film tile's left edge from a lamp's axis.
    `progress(paths, half_width)` is called after each round. The result does not depend on
    `threads`.

    Raises
    ------
    InputError
        when the mesh cannot be read or traced.
    TraceError
        when more than 1e-6 of the paths are lost.
    """
    from mpfcad.optics.engine import EYE, Source, trace
    from mpfcad.optics.mesh import read_film_mesh
    from mpfcad.optics.recorder import FLOWS, Tally
    from mpfcad.optics.scene import build_scene

    mesh = None if mesh_path is None else read_film_mesh(mesh_path)
    elements = stack.elements(mesh, offset)
    scene = build_scene(elements)
    position = np.linspace(0, 1, POINTS)
    source = Source(
        EYE, position * stack.lamp_pitch, stack["meter_spot_mm"], acceptance=stack.acceptance
    )
    tally = Tally.empty(POINTS, len(FLOWS) + len(elements))
    blocks = 0
    while True:
        # Rounds grow with what is done, so that few intervals are computed and little is overshot.
        more = max(_LEAST_BLOCKS, blocks // 4)
        tally = tally + trace(scene, source, more, seed=seed, first=blocks, threads=threads)
        blocks += more
        fit = fit_harmonics(position, tally.radiance, tally.radiance_error)
        contrast = contrast_of_harmonics(fit, seed)
        if progress:
            progress(tally.total_paths, contrast.half_width)
        if contrast.half_width <= half_width_goal or tally.total_paths >= path_limit:
            break
    lost = tally.fraction[FLOWS.index("lost")]
    if lost > 1e-6:
        raise TraceError(f"{mesh_path}: {lost:.2e} of the paths were lost; allowed 1e-6")
    return LuminanceResult(
        position,
        tally.radiance,
        tally.radiance_error,
        fit,
        contrast,
        Estimate.normal(float(fit.coefficient[0]), float(np.sqrt(fit.covariance[0, 0]))),
        _energy(scene, elements, seed, threads),
        tally.total_paths,
        scene.accelerators,
    )


def _energy(scene, elements, seed: int, threads: int) -> dict[str, object]:
    """Return where the lamps' light goes, from a forward trace, as shares of what they emit."""
    from mpfcad.optics.engine import LAMPS, Source, trace
    from mpfcad.optics.recorder import FLOWS

    tally = trace(
        scene, Source(LAMPS, np.zeros(1), 0.0), _ENERGY_BLOCKS, seed=seed, threads=threads
    )
    share = dict(zip(FLOWS, map(float, tally.fraction), strict=False))
    error = dict(zip(FLOWS, map(float, tally.fraction_error), strict=False))
    absorbed = {"lamps": share["lamps"]}
    absorbed.update({name: share[name] for name in ("walls", "rim") if share[name] > 0})
    for element, part in zip(elements, tally.fraction[len(FLOWS) :], strict=True):
        if part > 0:
            absorbed[element.name] = absorbed.get(element.name, 0.0) + float(part)
    total = sum(absorbed.values())
    return {
        "in": 1.0,
        "out": share["up"],
        "absorbed": total,
        "absorbed_by": absorbed,
        "lost": share["lost"],
        "imbalance": 1.0 - share["up"] - share["down"] - total - share["lost"],
        "imbalance_standard_error": error["roulette"],
        "paths": tally.total_paths,
    }
