"""Waves of Maxwell's equations in plates of any dielectric tensor: Berreman's 4 by 4 matrices.

Shares nothing with the tracer, which follows rays with Stokes vectors: no Fresnel formula and no
refracted direction. The field (Eₓ, H_y, E_y, -Hₓ) goes through a layer as exp(i k₀ Δ d), with Δ by
Berreman ("Optics in stratified and anisotropic media: 4×4-matrix formulation", JOSA 62, 1972).
Fields go as exp(-iωt). Plates lie in air.

A layer thicker than the light is coherent is averaged over the phase of its own waves, on a
lattice of equal steps in all layers of a plate at once (Korobov, 1959). Plates with air between
add as their Mueller matrices do: in coherent waves ways of equal length would interfere.
"""

import math
from dataclasses import dataclass

import numpy as np

WAVELENGTH = 550e-6
#: Points and generator of the lattice of phases.
_POINTS, _STEP = 127, 47
#: I, Q, U, V of E₁E₁*, E₁E₂*, E₂E₁*, E₂E₂*; U + iV = 2 E₁ E₂*.
_STOKES = np.array([[1, 0, 0, 1], [1, 0, 0, -1], [0, 1, 1, 0], [0, -1j, 1j, 0]])
#: The mirror image of a plate has p the other way round.
_MIRROR = np.diag([1.0, 1.0, -1.0, -1.0])


@dataclass(frozen=True)
class Layer:
    """A layer: index across the axis and along it, thickness [mm], the axis from y [rad].

    `thick`: its waves are averaged over a period of their phase.
    """

    index: complex
    thickness: float
    extraordinary: complex | None = None
    axis: float = 0.0
    thick: bool = True

    def tensor(self, turn: float) -> np.ndarray:
        """Return the dielectric tensor (3, 3) in axes turned by `turn` about z."""
        a = self.axis - turn
        along = np.array([-math.sin(a), math.cos(a), 0.0])
        late = self.index if self.extraordinary is None else self.extraordinary
        return self.index**2 * np.eye(3) + (late**2 - self.index**2) * np.outer(along, along)


def _waves(layer: Layer, sine: float, turn: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the four waves of a layer: k_z over k₀, (4,), and their fields, (4, 4) by columns."""
    e, k = layer.tensor(turn), sine
    xx, xy, yx, yy, zz = e[0, 0], e[0, 1], e[1, 0], e[1, 1], e[2, 2]
    delta = np.array(
        [[0, 1 - k * k / zz, 0, 0], [xx, 0, xy, 0], [0, 0, 0, 1], [yx, 0, yy - k * k, 0]], complex
    )
    return np.linalg.eig(delta)


def _mueller(layers: list[Layer], k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what a plate passes of light along k and reflects of it, (4, 4) each.

    k (3,) goes up. The first axis is p, in the plane of k and z, the second s; p × s is the light's
    direction, before and after.
    """
    sine, cosine, turn = math.hypot(k[0], k[1]), k[2], math.atan2(k[1], k[0])
    through = np.eye(4, dtype=complex)
    for number, layer in enumerate(layers):
        wave, field = _waves(layer, sine, turn)
        phase = np.arange(_POINTS) * pow(_STEP, number, _POINTS) % _POINTS / _POINTS
        period = WAVELENGTH / np.abs(wave.real).mean() if layer.thick else 0.0
        step = np.exp(2j * np.pi / WAVELENGTH * np.outer(layer.thickness + phase * period, wave))
        through = (field * step[:, None, :]) @ np.linalg.inv(field) @ through
    up = np.array([[cosine, 0], [1, 0], [0, 1], [0, cosine]], complex)
    down = np.array([[-cosine, 0], [1, 0], [0, 1], [0, -cosine]], complex)
    # Above are `up` of what passes; below `up` of what comes and `down` of what is reflected.
    faces = np.concatenate([np.broadcast_to(up, (_POINTS, 4, 2)), -through @ down], axis=2)
    leaves = np.linalg.solve(faces, through @ up)

    def mean(jones: np.ndarray) -> np.ndarray:
        pairs = np.einsum("nij,nkl->ikjl", jones, jones.conj()).reshape(4, 4) / _POINTS
        return (_STOKES @ pairs @ np.linalg.inv(_STOKES)).real

    return mean(leaves[:, :2]), mean(leaves[:, 2:])


def pile(plates: list[list[Layer]], k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what plates pass of light along k, and reflect up of light that comes down, (4, 4)."""
    whole, above = np.eye(4), np.zeros((4, 4))
    for layers in plates:
        passes, below = _mueller(layers, k)
        over = [_MIRROR @ one @ _MIRROR for one in _mueller(layers[::-1], k)]
        between = passes @ np.linalg.inv(np.eye(4) - above @ below)
        whole, above = between @ whole, over[1] + between @ above @ over[0]
    return whole, above


def _axes(k: np.ndarray) -> np.ndarray:
    """Return the unit vectors (2, 3) of p and s of light along k."""
    turn = math.atan2(k[1], k[0])
    s = np.array([-math.sin(turn), math.cos(turn), 0.0])
    return np.array([np.cross(s, k), s])


def stokes(field: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Return I, Q, U, V of a field (3,) along k in the axes of `pile`."""
    one, two = _axes(k) @ field
    pairs = [
        one * one.conjugate(),
        one * two.conjugate(),
        two * one.conjugate(),
        two * two.conjugate(),
    ]
    return (_STOKES @ np.array(pairs)).real


def as_seen(light: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Return I, Q, U, V as a meter of the panel reads them: the first axis is y as seen along k.

    The second lies 90° anticlockwise from it, as seen from above.
    """
    y = np.cross([1.0, 0.0, 0.0], k)
    p, s = _axes(k) @ y
    angle = 2 * math.atan2(s, p)
    c, d = math.cos(angle), math.sin(angle)
    return np.array([light[0], c * light[1] + d * light[2], c * light[2] - d * light[1], light[3]])
