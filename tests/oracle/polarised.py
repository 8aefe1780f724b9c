"""The oracle's polarised light: coherency matrices of the field in space, in plain numpy.

No Stokes vectors, no Mueller matrices and no axes that go along: light is ⟨E E†⟩, a Hermitian 3 by
3 matrix in the scene's own axes, and what it meets is a matrix P of complex amplitudes
(Chipman, Lam and Young, "Polarized light and optical systems", 2018, chapter 9): J becomes P J P†.
"""

import cmath
import math

import numpy as np

from oracle.ray import Philox, Vector

_Z = np.array([0.0, 0.0, 1.0])


def unpolarised(d) -> np.ndarray:
    """Return the matrix of unpolarised light of intensity 1 along d."""
    return (np.eye(3) - np.outer(d, d)) / 2


def fresnel(cos_in: float, n_in: float, n_out: float) -> tuple[complex, complex]:
    """Return the amplitudes r_s and r_p, complex beyond the critical angle."""
    sine = n_in * math.sqrt(max(0.0, 1 - cos_in**2)) / n_out
    cos_out = cmath.sqrt(1 - sine**2)
    r_s = (n_in * cos_in - n_out * cos_out) / (n_in * cos_in + n_out * cos_out)
    r_p = (n_out * cos_in - n_in * cos_out) / (n_out * cos_in + n_in * cos_out)
    return r_s, r_p


class PolarisedPhilox(Philox):
    """The path's random numbers with the light of the four meters: `light` (4, 3, 3) complex.

    The first is that of the plain meter, of intensity 1; the others are read as Q, U and V.
    """

    def start(self, d: Vector) -> None:
        d = np.array(d)
        e = np.cross(d, [1.0, 0.0, 0.0])
        e /= np.linalg.norm(e)
        f = np.cross(d, e)
        q = (np.outer(e, e) - np.outer(f, f)) / 2
        u = -(np.outer(e, f) + np.outer(f, e)) / 2
        v = 1j * (np.outer(e, f) - np.outer(f, e)) / 2
        self.light = np.array([unpolarised(d), q, u, v], complex)
        self.even = None

    @property
    def meters(self) -> np.ndarray:
        return self.intensity

    def begin_again(self, meters: np.ndarray) -> None:
        self.even = meters

    @property
    def intensity(self) -> np.ndarray:
        """What each meter sees of unpolarised light of 1 that comes along the path, (4,)."""
        if self.even is not None:
            return self.even
        return np.trace(self.light, axis1=1, axis2=2).real

    def seen(self, radiance: float) -> np.ndarray:
        return radiance * self.intensity

    def _meet(self, p: np.ndarray) -> np.ndarray:
        return p @ self.light @ p.conj().T

    def _take(self, light: np.ndarray) -> None:
        self.light = light / np.trace(light[0]).real

    def reflects(self, d: Vector, n: Vector, n_in: float, n_out: float) -> bool:
        d, n = np.array(d), np.array(n)
        self._along(d)
        s = np.cross(d, n)
        if np.linalg.norm(s) < 1e-13:
            s = np.cross(d, [0.6, 0.8, 0.0])
        s /= np.linalg.norm(s)
        cos_in = min(1.0, abs(float(d @ n)))
        r_s, r_p = fresnel(cos_in, n_in, n_out)
        back = d - 2 * (d @ n) * n
        mirrored = r_s * np.outer(s, s) + r_p * np.outer(np.cross(back, s), np.cross(d, s))
        light = self._meet(mirrored)
        if self() < np.trace(light[0]).real:
            self._take(light)
            return True
        ratio = n_in / n_out
        cos_out = math.sqrt(1 - ratio**2 * (1 - cos_in**2))
        on = ratio * d + (cos_out - ratio * cos_in) * math.copysign(1.0, d @ n) * n
        t_s, t_p = math.sqrt(1 - abs(r_s) ** 2), math.sqrt(1 - abs(r_p) ** 2)
        through = t_s * np.outer(s, s) + t_p * np.outer(np.cross(on, s), np.cross(d, s))
        self._take(self._meet(through))
        return False

    def depolarise(self) -> None:
        self.even = self.intensity

    def _along(self, d: np.ndarray) -> None:
        """Take the direction of light that was depolarised before it had one."""
        if self.even is not None:
            self.light = self.even[:, None, None] * unpolarised(d)
            self.even = None

    def mirror(self, n: Vector) -> None:
        self.light = self._meet(2 * np.outer(n, n) - np.eye(3))

    def scatter(self, d: Vector, k: Vector, passed: bool, kept: float) -> None:
        d, k = np.array(d), np.array(k)
        self._along(d)
        whole = self.intensity
        if passed:
            axis, cosine = np.cross(d, k), float(d @ k)
            x, y, z = axis
            cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            self.light = self._meet(np.eye(3) + cross + cross @ cross / (1 + cosine))
        else:
            self.mirror((0.0, 0.0, 1.0))
        rest = whole[:, None, None] * unpolarised(k)
        self.light = kept * self.light + (1 - kept) * rest

    def turn(self, angle: float, flipped: bool = False) -> None:
        c, s = math.cos(angle), math.sin(angle)
        p = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        self.light = self._meet(np.diag([-1.0, 1.0, -1.0]) @ p if flipped else p)

    def delay(self, slab, d: Vector, step: float) -> None:
        d, axis = np.array(d), np.array([-math.sin(slab.axis), math.cos(slab.axis), 0.0])
        self._along(d)
        sine2 = 1 - float(d @ axis) ** 2
        late = axis - (d @ axis) * d
        late /= np.linalg.norm(late)
        early = np.cross(d, late)
        phase = slab.delay * sine2 * step
        both = cmath.exp(1j * phase) * np.outer(late, late) + np.outer(early, early)
        self._take(self._meet(both))

    def splits(self, layer, d: Vector) -> tuple[bool, float]:
        """Return whether a ray passes a polariser or retarder, and what is left of its light."""
        d = np.array(d)
        self._along(d)
        c = np.array([math.cos(layer.axis), math.sin(layer.axis), 0.0])
        t = np.cross(d, c)
        t /= np.linalg.norm(t)
        f = np.cross(d, t)
        along, across = map(math.sqrt, layer.transmittance)
        through = along * cmath.exp(1j * layer.retardation) * np.outer(t, t)
        passing = self._meet(through + across * np.outer(f, f))
        along, across = map(math.sqrt, layer.reflectance)
        mirror = 2 * np.outer(_Z, _Z) - np.eye(3)
        going = self._meet(mirror @ (along * np.outer(t, t) + across * np.outer(f, f)))
        on, back = (float(np.trace(light[0]).real) for light in (passing, going))
        passed = self() * (on + back) < on
        if on + back > 0:
            self._take(passing if passed else going)
        return passed, on + back
