"""The oracle's random numbers, vectors, Fresnel's formulas and facets, in plain Python."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from mpfcad.optics.base.net import DIMENSIONS, NET, direction_numbers

_ALL = 2**64 - 1
Vector = tuple[float, float, float]


class Philox:
    """Philox4x32-10 in Python integers, counted by (draw, stream, path).

    With `points`, the first numbers are those of the path's net, one for each point of the meter.
    """

    def __init__(self, seed: int, stream: int, path: int, points: int = 0) -> None:
        self.key = (seed & 0xFFFFFFFF, seed >> 32)
        self.tail = [stream, path & 0xFFFFFFFF, path >> 32]
        self.block = 0
        self.ready: list[float] = []
        if points:
            turn, point = divmod(path, points)
            net, index = divmod(turn, NET)
            self.ready = self._of_net(stream, net * points + point, index)

    def __call__(self) -> float:
        """Return the next number in [0, 1)."""
        if not self.ready:
            a, b, c, d = self._words([self.block, *self.tail])
            self.block += 1
            self.ready = [((a << 32 | b) >> 11) * 2.0**-53, ((c << 32 | d) >> 11) * 2.0**-53]
        return self.ready.pop(0)

    def reflects(self, d: Vector, n: Vector, n_in: float, n_out: float) -> bool:
        """Return whether a ray is reflected at an interface of normal n, by the next number."""
        return self() < reflectance(abs(dot(d, n)), n_in, n_out)

    @property
    def meters(self) -> np.ndarray:
        """What each meter sees of light of 1: one meter, and all of it (`PolarisedPhilox`)."""
        return np.ones(1)

    def begin_again(self, meters: np.ndarray) -> None:
        """Start the path again, unpolarised, of which the meters see so much."""

    def depolarise(self) -> None:
        """Make light unpolarised: this light always is (`PolarisedPhilox`)."""

    def delay(self, slab, d: Vector, step: float) -> None:
        """Delay light polarised along the axis of a uniaxial plate, over a path."""

    def mirror(self, n: Vector) -> None:
        """Reflect the light's state as a perfect mirror of normal n does."""

    def scatter(self, d: Vector, k: Vector, passed: bool, kept: float) -> None:
        """Carry the light's state from direction d to k; `kept` of its polarisation stays."""

    def start(self, d: Vector) -> None:
        """Start a path along d."""

    def turn(self, angle: float, flipped: bool = False) -> None:
        """Turn the light's state about z, or upside down."""

    def seen(self, radiance: float) -> float:
        """Return what a meter sees of a radiance that the path has found."""
        return radiance

    def happens(self, element: object, name: str, log_density: Callable[[float], float]) -> None:
        """Hear ln of an event's density, or of the weight it leaves, as a function of a value."""

    def found(self, radiance: float, by_share: float = 0.0) -> None:
        """Hear of light as it is found, and of its own derivative by the mirrored share."""

    def _of_net(self, stream: int, net: int, index: int) -> list[float]:
        a, b, _, _ = self._words([0xFFFFFFFF, stream, net & 0xFFFFFFFF, net >> 32])
        key, numbers = (a << 32 | b) // NET * NET, []
        for dimension in range(DIMENSIONS):
            digits, seed = 0, (key + dimension * 0x9E3779B97F4A7C15) & _ALL
            for bit, number in enumerate(direction_numbers(dimension)):
                if index >> bit & 1:
                    digits ^= number
            for shift, factor in ((32, 0xBF58476D1CE4E5B9), (29, 0x94D049BB133111EB), (32, 1)):
                seed = (seed ^ seed >> shift) * factor & _ALL
            x = int(f"{digits:010b}"[::-1], 2)
            x ^= x * 0x6C50B47C3D20ADEA & _ALL
            x = (x + seed) * (seed >> 32 | 1) & _ALL
            for even in (0x2F1C9D6405526C56, 0x1D8E4E2753A22864):
                x ^= x * even & _ALL
            numbers.append((int(f"{x:064b}"[::-1], 2) >> 11) * 2.0**-53)
        return numbers

    def _words(self, word: list[int]) -> list[int]:
        k0, k1 = self.key
        for _ in range(10):
            p0, p1 = 0xD2511F53 * word[0], 0xCD9E8D57 * word[2]
            word = [
                (p1 >> 32) ^ word[1] ^ k0, p1 & 0xFFFFFFFF,
                (p0 >> 32) ^ word[3] ^ k1, p0 & 0xFFFFFFFF,
            ]  # fmt: skip
            k0, k1 = (k0 + 0x9E3779B9) & 0xFFFFFFFF, (k1 + 0xBB67AE85) & 0xFFFFFFFF
        return word


def reflectance(cos_in: float, n_in: float, n_out: float) -> float:
    """Return the unpolarised Fresnel reflectance, from the angles (1 beyond the critical one)."""
    angle_in = math.acos(min(1.0, cos_in))
    sine = n_in * math.sin(angle_in) / n_out
    if sine >= 1.0:
        return 1.0
    angle_out = math.asin(sine)
    if angle_in < 1e-7 or n_in == n_out:
        return ((n_in - n_out) / (n_in + n_out)) ** 2
    minus, plus = angle_in - angle_out, angle_in + angle_out
    s, p = math.sin(minus) / math.sin(plus), math.tan(minus) / math.tan(plus)
    return (s * s + p * p) / 2


def refract(d: Vector, n: Vector, n_in: float, n_out: float) -> Vector:
    """Return the refracted direction; n is the unit normal on the side of the ray's arrival."""
    ratio = n_in / n_out
    cos_in = -dot(d, n)
    cos_out = math.sqrt(1 - ratio**2 * (1 - cos_in**2))
    return tuple(ratio * a + (ratio * cos_in - cos_out) * b for a, b in zip(d, n, strict=True))


def dot(a: Vector, b: Vector) -> float:
    """Return a · b."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a: Vector, b: Vector) -> Vector:
    """Return a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def facet_distance(corners: Sequence[Vector], o: Vector, d: Vector) -> float | None:
    """Return the distance from o along d to a facet, or None."""
    e1, e2 = minus(corners[1], corners[0]), minus(corners[2], corners[0])
    p = cross(d, e2)
    determinant = dot(e1, p)
    if determinant == 0:
        return None
    s = minus(o, corners[0])
    u = dot(s, p) / determinant
    q = cross(s, e1)
    v = dot(d, q) / determinant
    if u < 0 or v < 0 or u + v > 1:
        return None
    return dot(e2, q) / determinant


def exp(x):
    """Return e to the power of a number, or of one for each band (`oracle.bands`)."""
    return x.exp() if hasattr(x, "exp") else math.exp(x)


def disk(rng: Philox) -> tuple[float, float]:
    """Return a point uniform in the unit disk."""
    radius = math.sqrt(rng())
    angle = 2 * math.pi * rng()
    return radius * math.cos(angle), radius * math.sin(angle)


def about(axis: Vector, cosine: float, azimuth: float) -> Vector:
    """Return the direction at an angle about an axis (frame of Duff et al., 2017)."""
    x, y, z = axis
    sign = math.copysign(1.0, z)
    a = -1 / (sign + z)
    t = (1 + sign * x * x * a, sign * x * y * a, -sign * x)
    b = (x * y * a, sign + y * y * a, -y)
    sine = math.sqrt(max(0.0, 1 - cosine**2))
    p, q = sine * math.cos(azimuth), sine * math.sin(azimuth)
    return tuple(p * t[i] + q * b[i] + cosine * axis[i] for i in range(3))


def lambertian(normal: Vector, rng: Philox) -> Vector:
    """Return a cosine-weighted direction about a normal."""
    px, py = disk(rng)
    rng.depolarise()
    return about(normal, math.sqrt(1 - px * px - py * py), math.atan2(py, px))


def roulette(weight: float, rng: Philox) -> float:
    """Return the weight with which a path goes on: faint ones end half of the time."""
    if weight >= 0.1 or weight == 0:
        return weight
    return 0.0 if rng() < 0.5 else 2 * weight


def scattering_cosine(phase: Sequence[float] | None, g: float, u: float) -> float:
    """Return the cosine of one scattering: from a table of quantiles, else of Henyey-Greenstein."""
    if phase is not None:
        place = u * (len(phase) - 1)
        i = int(place)
        return phase[i] + (place - i) * (phase[i + 1] - phase[i])
    if g == 0:
        return 2 * u - 1
    return (1 + g * g - ((1 - g * g) / (1 - g + 2 * g * u)) ** 2) / (2 * g)
