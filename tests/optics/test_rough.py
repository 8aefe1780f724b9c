"""Rough facets: the oracle, energy and reciprocity, and what a Gaussian surface must do."""

import math
from dataclasses import replace

import numpy as np
import pytest
from harness import BARE, compiled, film_mesh, groove, pass_layers
from numba import njit, uint64
from test_film_materials import passed
from test_reference import BOTTOM, CAVITY, TOP, compare

from mpfcad.errors import InputError
from mpfcad.optics.base.sampling import RNG_SIZE, disk, start_path
from mpfcad.optics.element import Film
from mpfcad.optics.film import interface as surface
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.scene import build_scene
from mpfcad.store.kernel import kept

FILLED = [groove(60.0, chords=5), groove(30.0, chords=5)]
INDEX = 1.55


@kept
@njit(error_model="numpy")
def lambertian_pairs(n_in, n_out, slope, seed, out):
    """Send Lambertian light to a surface of normal z; out (n, 2): cosines before and after.

    The second is below 0 where the light has passed.
    """
    rng = np.zeros(RNG_SIZE, np.uint64)
    for i in range(len(out)):
        start_path(rng, uint64(seed), uint64(9), uint64(i))
        dx, dy = disk(rng)
        dz = -np.sqrt(max(0.0, 1.0 - dx * dx - dy * dy))
        _, _, _, z = surface.interface(n_in / n_out, slope, 0.0, 0.0, 1.0, dx, dy, dz, None, rng)
        out[i, 0], out[i, 1] = -dz, z


@kept
@njit(error_model="numpy")
def reflected(slope, dx, dz, seed, out):
    """Reflect one direction of light at a mirror-like rough surface; out (n, 3): directions."""
    rng = np.zeros(RNG_SIZE, np.uint64)
    for i in range(len(out)):
        start_path(rng, uint64(seed), uint64(9), uint64(i))
        _, out[i, 0], out[i, 1], out[i, 2] = surface.interface(
            1e6, slope, 0.0, 0.0, 1.0, dx, 0.0, dz, None, rng
        )


def film(folder, grooves=FILLED, accelerator=None, roughness=0.15, **resin):
    own = Resin(film_mesh(folder, [BARE] * len(grooves)), **resin)
    mesh = film_mesh(folder, grooves)
    return Film(mesh, INDEX, offset=0.013, accelerator=accelerator, resin=own, roughness=roughness)


@pytest.mark.parametrize("accelerator", ["chain", "bvh"])
@pytest.mark.parametrize("how", [{}, {"index": 1.48}], ids=str)
def test_paths_through_rough_prisms_equal_the_oracle(tmp_path, accelerator, how):
    compare([CAVITY, BOTTOM, film(tmp_path, accelerator=accelerator, **how), TOP], 30, grown=1 / 30)


def test_a_rough_film_without_resin_equals_the_oracle(tmp_path):
    bare = Film(film_mesh(tmp_path, [BARE] * 2), INDEX, roughness=0.4, absorption=1.0)
    compare([bare, replace(bare, rotation=0.4, flipped=True)], 30, below=1.0)


@pytest.mark.parametrize("slope", [0.1, 0.5])
def test_light_goes_each_way_as_much_as_back(slope):
    """Of light as bright from both sides, as much goes from one direction to another as back."""
    bins, count = 6, 300_000
    edge = np.linspace(0, 1, bins + 1) ** 0.5
    pair = np.zeros((2 * bins, 2 * bins))
    for side, (n_in, n_out) in enumerate(((1.0, INDEX), (INDEX, 1.0))):
        # Flux of equal radiance over n² is proportional to n².
        out = np.empty((round(count * n_in**2), 2))
        lambertian_pairs(n_in, n_out, slope, 3 + side, out)
        start = side * bins + np.clip(np.searchsorted(edge, out[:, 0]) - 1, 0, bins - 1)
        goes = side ^ (out[:, 1] < 0)
        end = goes * bins + np.clip(np.searchsorted(edge, abs(out[:, 1])) - 1, 0, bins - 1)
        np.add.at(pair, (start, end), 1)
    above = np.triu_indices(2 * bins, 1)
    there, back = pair[above], pair.T[above]
    enough = there + back > 50
    there, back, degrees = there[enough], back[enough], enough.sum()
    chi2 = ((there - back) ** 2 / (there + back)).sum()
    assert degrees > 40
    assert abs(chi2 - degrees) < 4 * math.sqrt(2 * degrees), (chi2, degrees)


@pytest.mark.parametrize("tilt", [0.0, 0.5])
def test_a_mirror_spreads_light_by_twice_its_slopes(tilt):
    # To second order the reflected direction turns by twice the slope, in its plane and across it.
    slope, count = 0.01, 100_000
    out = np.empty((count, 3))
    reflected(slope, math.sin(tilt), -math.cos(tilt), 4, out)
    angle = np.arctan2(out[:, 0], out[:, 2]) - tilt
    across = out[:, 1] / math.cos(tilt)
    for spread in (angle, across):
        assert spread.std() == pytest.approx(2 * slope, rel=0.02)
    # A slope is seen as much as it faces the light: the mean moves by 2 slope² tan.
    assert angle.mean() == pytest.approx(2 * slope**2 * math.tan(tilt), abs=4 * 2e-2 / count**0.5)


def test_seen_slopes_are_their_density():
    # χ² of slopes along the view against (A - s) φ(s).
    @njit(error_model="numpy")
    def slopes(seed, x, z, slope, out):
        rng = np.zeros(RNG_SIZE, np.uint64)
        for i in range(len(out)):
            start_path(rng, uint64(seed), uint64(9), uint64(i))
            mx, _, mz = surface.microfacet(x, 0.0, z, slope, rng)
            out[i] = -mx / mz / slope

    sine, slope, count = math.sin(1.2), 0.3, 200_000
    out = np.empty(count)
    slopes(5, sine, math.cos(1.2), slope, out)
    edge = math.cos(1.2) / (sine * slope)
    grid = np.linspace(-5, edge, 200_001)
    density = (edge - grid) * np.exp(-(grid**2) / 2)
    share = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2)])
    share /= share[-1]
    cut = np.interp(np.linspace(0, 1, 41), share, grid)
    found, _ = np.histogram(out, cut)
    chi2 = ((found - count / 40) ** 2 / (count / 40)).sum()
    assert chi2 < 39 + 4 * math.sqrt(2 * 39), chi2


def test_smiths_shadow_is_the_mean_of_the_slopes_beyond():
    shadow = compiled(surface.shadow)
    for angle in (0.3, 1.0, 1.4, 1.9, 2.8):
        own = 1 / (math.tan(angle) * 0.3)
        grid = np.linspace(own, max(own, 0) + 12, 400_001)
        beyond = np.trapezoid((grid - own) * np.exp(-(grid**2) / 2), grid) / math.sqrt(2 * math.pi)
        found = shadow(math.sin(angle), 0.0, math.cos(angle), 0.3)
        assert found == pytest.approx(beyond / own, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("resin", [{}, {"index": 1.48}], ids=str)
def test_nothing_is_lost_and_light_passes_both_ways_alike(tmp_path, resin):
    one = film(tmp_path, roughness=0.3, **resin)
    up, down = (passed([one], side, seed=3) for side in (True, False))
    assert abs(up[0][0] - down[0][0]) < 4 * math.hypot(up[0][1], down[0][1])
    for (through, _), (back, _) in (up, down):
        assert through + back == pytest.approx(1, abs=1e-12)


def test_resin_hides_the_roughness_of_prisms_of_its_index(tmp_path):
    full = [groove(0.0)]
    rough = passed([film(tmp_path, full, roughness=0.3)], True)
    smooth = passed([Film(film_mesh(tmp_path, full), INDEX)], True, seed=2)
    assert abs(rough[0][0] - smooth[0][0]) < 4 * math.hypot(rough[0][1], smooth[0][1])


def test_a_rough_prism_film_brightens_less(tmp_path):
    share = []
    for roughness in (0.0, 0.3):
        out = np.empty((100_000, 4))
        bare = Film(film_mesh(tmp_path, [BARE]), INDEX, roughness=roughness)
        pass_layers(build_scene([bare]), True, 6, out)
        share.append(np.mean((out[:, 0] == 1) & (np.hypot(out[:, 1], out[:, 2]) < 0.5)))
    assert share[1] < share[0] - 4 * math.sqrt(2 * share[0] / 100_000)


def test_a_negative_roughness_is_refused(tmp_path):
    with pytest.raises(InputError, match="roughness"):
        film(tmp_path, roughness=-0.1)
