"""Measured luminance: the contrast of known curves and images, however a camera saw them."""

import numpy as np
import pytest
import tifffile

from mpfcad.errors import InputError
from mpfcad.measure.observed import (
    Photo,
    askew_words,
    curve_of_image,
    find_pitch,
    observe_cell,
    observe_pitch,
    read_curve,
    read_image,
)
from mpfcad.record.judgement import describe_cell_difference

PITCH, CONTRAST, MEAN = 16.0, 0.02, 5000.0


def wave(x, contrast=CONTRAST, pitch=PITCH, lamp=3.0):
    """Return a curve of a first harmonic whose contrast is its amplitude over the mean."""
    return MEAN * (1 + contrast * np.cos(2 * np.pi * (x - lamp) / pitch))


def write_curve(path, noise=0.0, seed=1, length=80.0, contrast=CONTRAST):
    x = np.arange(0.0, length, 0.25)
    value = wave(x, contrast) + np.random.default_rng(seed).normal(0, noise, len(x))
    lines = "\n".join(f"{a:.3f};{b:.3f}".replace(".", ",") for a, b in zip(x, value, strict=True))
    path.write_text("Position [mm];Leuchtdichte [cd/m²]\n" + lines + "\n", "cp1252")
    return path


def test_a_curve_is_read_found_and_judged(tmp_path):
    curve = read_curve(write_curve(tmp_path / "l.csv", noise=10.0))
    assert "decimal comma" in curve.reading
    assert "cp1252" in curve.reading
    assert curve.error[0] == pytest.approx(10.0, rel=0.25)
    pitch = find_pitch("l.csv", curve.position, curve.luminance)
    assert pitch == pytest.approx(PITCH, rel=2e-3)
    found = observe_pitch(curve, pitch)
    assert (found.lamp - 3.0 + PITCH / 2) % PITCH - PITCH / 2 == pytest.approx(0.0, abs=0.05)
    assert len(found.each) == 4
    assert found.contrast.low <= CONTRAST <= found.contrast.high
    assert found.contrast.half_width < 0.003
    assert found.fit.mean.value == pytest.approx(MEAN, rel=1e-3)


def test_intervals_hold_a_pitch_s_contrast(tmp_path):
    """Of 40 noisy curves of one pitch 38 ± 1.4 should: 32 is 4.3 standard deviations away."""
    held = 0
    for seed in range(40):
        curve = read_curve(write_curve(tmp_path / "l.csv", 15.0, seed, length=20.0))
        contrast = observe_pitch(curve, PITCH).contrast
        held += contrast.low <= CONTRAST <= contrast.high
    assert held >= 32


def image(rows=120, columns=640, pixel=0.125, turn=0.0, contrast=CONTRAST):
    x, y = np.meshgrid((np.arange(columns) + 0.5) * pixel, (np.arange(rows) + 0.5) * pixel)
    return wave(x * np.cos(turn) - y * np.sin(turn), contrast)


def counts(luminance, seed=1):
    """Return 16-bit counts of luminance at 0.25 cd/m² a count, with a dark level and vignetting."""
    rng = np.random.default_rng(seed)
    dark = 200 + rng.normal(0, 2, luminance.shape)
    rows, columns = luminance.shape
    flat = 1 - 0.2 * ((np.arange(columns) / columns - 0.5) ** 2)[None] * np.ones((rows, 1))
    seen = luminance / 0.25 * flat + dark + rng.normal(0, 40, luminance.shape)
    return [np.round(part).astype(np.uint16) for part in (seen, dark, 20000 * flat + dark)]


@pytest.mark.parametrize("kind", ["tiff", "fits", "exr", "csv"])
def test_an_image_of_any_kind_gives_its_contrast(tmp_path, kind):
    value = image()
    path = tmp_path / f"photo.{kind}"
    if kind == "tiff":
        tifffile.imwrite(path, np.round(value / 0.25).astype(np.uint16))
    elif kind == "fits":
        fits = pytest.importorskip("astropy.io.fits")
        fits.PrimaryHDU(np.round(value / 0.25).astype(np.int32)).writeto(path)
    elif kind == "exr":
        exr = pytest.importorskip("OpenEXR")
        pixels = {"Y": (value / 0.25).astype(np.float32)}
        exr.File({"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}, pixels).write(
            str(path)
        )
    else:
        np.savetxt(path, np.round(value / 0.25), "%d", ";")
    curve = curve_of_image(read_image(path, Photo(0.125, 0.25)))
    found = observe_pitch(curve, PITCH)
    assert found.contrast.value == pytest.approx(CONTRAST, abs=2e-4)
    assert found.fit.mean.value == pytest.approx(MEAN, rel=1e-3)


def test_dark_flat_crop_and_rotation_are_taken_into_account(tmp_path):
    turn = np.radians(2.0)
    names = [tmp_path / f"{name}.tif" for name in ("photo", "dark", "flat")]
    for path, frame in zip(names, counts(image(rows=200, turn=turn)), strict=True):
        tifffile.imwrite(path, frame)
    photo = Photo(0.125, 0.25, names[1], names[2], (10, 5, 630, 195), turn)
    curve = curve_of_image(read_image(names[0], photo))
    pitch = find_pitch("photo", curve.position, curve.luminance)
    assert pitch == pytest.approx(PITCH, rel=5e-3)
    found = observe_pitch(curve, PITCH)
    assert found.contrast.value == pytest.approx(CONTRAST, abs=1e-3)
    # Without the flat the vignetting is most of it.
    raw = curve_of_image(read_image(names[0], Photo(0.125, 0.25, names[1])))
    assert observe_pitch(raw, PITCH).contrast.value > CONTRAST + 2e-3


def test_a_dark_frame_is_taken_off_the_flat_field_too(tmp_path):
    """Without noise the light itself comes back, though half of the frame has 1000 dark counts."""
    lens = np.linspace(0.5, 1.5, 32)[None] * np.ones((20, 1))
    light = 4000 + 100 * np.cos(np.arange(32))[None] * np.ones((20, 1))
    dark = np.where(np.arange(32) < 16, 1000.0, 0.0)[None] * np.ones((20, 1))
    frames = {"photo": light * lens + dark, "dark": dark, "flat": 2000 * lens + dark}
    for name, frame in frames.items():
        np.savetxt(tmp_path / f"{name}.csv", frame, "%.9f", ";")
    photo = Photo(0.5, 0.25, tmp_path / "dark.csv", tmp_path / "flat.csv")
    curve = curve_of_image(read_image(tmp_path / "photo.csv", photo))
    assert curve.luminance == pytest.approx(0.25 * light[0], rel=1e-9)
    assert curve.position == pytest.approx(0.5 * np.arange(32) + 0.25)


def test_an_image_is_turned_the_way_that_its_angle_says(tmp_path):
    """Stripes that run askew run down the columns afterwards, and twice as askew the other way."""
    turn = np.radians(8.0)
    np.savetxt(tmp_path / "photo.csv", image(rows=200, turn=turn), "%.6f", ";")
    spread = []
    for rotation in (turn, -turn):
        light = read_image(tmp_path / "photo.csv", Photo(0.125, rotation=rotation)).luminance
        spread.append(light.std(axis=0).max() / light.std())
    assert spread[0] < 0.02 and spread[1] > 0.3


def test_stripes_askew_are_said_with_the_rotation_that_sets_them_right(tmp_path):
    """5° over 25 mm hide 3 % of a contrast over 16 mm; the wrong way they are 10°, and 12 %."""
    turn, path = np.radians(5.0), tmp_path / "photo.csv"
    noise = np.random.default_rng(8).normal(0, 40, (200, 640))
    np.savetxt(path, image(rows=200, turn=turn) + noise, "%.3f", ";")
    right, none, wrong = (read_image(path, Photo(0.125, rotation=r)) for r in (turn, 0.0, -turn))
    assert askew_words(path, right, curve_of_image(right)) == ""
    for seen, words in (
        (none, r"hides .* --rotation-deg (4.9|5\.[0-3])"),
        (wrong, r"\+(9.[7-9]|10\.[0-3]).* askew after .*-5"),
    ):
        with pytest.raises(InputError, match=words):
            askew_words(path, seen, curve_of_image(seen))
    found = observe_pitch(curve_of_image(right), PITCH)
    assert found.contrast.low <= CONTRAST <= found.contrast.high
    # A little askew is said, and judged.
    np.savetxt(path, image(rows=200, turn=turn) + noise / 20, "%.3f", ";")
    little = read_image(path, Photo(0.125, rotation=turn + np.radians(2.0)))
    assert "the stripes run -" in askew_words(path, little, curve_of_image(little))


def test_the_noise_of_an_image_askew_is_the_noise(tmp_path):
    """Pixels are not mixed: an error of 40/√(pixels of a column), turned or not."""
    noise = np.random.default_rng(8).normal(0, 40, (200, 640))
    np.savetxt(tmp_path / "photo.csv", image(rows=200, turn=0.05) + noise, "%.3f", ";")
    curve = curve_of_image(read_image(tmp_path / "photo.csv", Photo(0.125, rotation=0.05)))
    assert np.median(curve.error) == pytest.approx(40 / np.sqrt(200), rel=0.05)


def test_spots_have_the_contrast_of_their_cell(tmp_path):
    """Product of two waves of 3 %: contrast (1.03² - 0.97²)/(1.03² + 0.97²) = 0.0599."""
    pixel = 0.25
    x, y = np.meshgrid((np.arange(320) + 0.5) * pixel, (np.arange(240) + 0.5) * pixel)
    across, along = (1 + 0.03 * np.cos(2 * np.pi * v / p) for v, p in ((x, 16.0), (y, 12.0)))
    value = MEAN * across * along
    value += np.random.default_rng(4).normal(0, 20, value.shape)
    path = tmp_path / "spots.tif"
    tifffile.imwrite(path, value.astype(np.float32))
    seen = read_image(path, Photo(pixel))
    found = observe_cell(seen, (16.0, 12.0))
    assert found.cells >= 12
    assert found.contrast.low <= 0.0599 <= found.contrast.high
    assert found.contrast.half_width < 0.003
    assert found.series.amplitude(1, 0).value == pytest.approx(0.03, abs=1e-3)
    assert found.luminance.mean() == pytest.approx(MEAN, rel=2e-3)


def test_spots_against_a_prediction_show_what_differs(tmp_path):
    """Predicted 3 % across, seen 3 % and 1 % of a second harmonic, a third of a cell beside it."""
    pixel, bins = 0.25, 24
    x, y = np.meshgrid((np.arange(320) + 0.5) * pixel, (np.arange(240) + 0.5) * pixel)
    u, v = x / 16.0 - 1 / 3, y / 12.0
    value = MEAN * (1 + 0.03 * np.cos(2 * np.pi * u) + 0.01 * np.cos(4 * np.pi * v))
    value += np.random.default_rng(4).normal(0, 10, value.shape)
    path = tmp_path / "spots.tif"
    tifffile.imwrite(path, value.astype(np.float32))
    found = observe_cell(read_image(path, Photo(pixel)), (16.0, 12.0))
    middle = (np.arange(bins) + 0.5) / bins - 0.5
    level = 0.8 * MEAN * (1 + 0.03 * np.sinc(1 / bins) * np.cos(2 * np.pi * middle))
    cell = {
        "luminance_cd_m2": np.repeat(level[:, None], bins, axis=1).tolist(),
        "standard_error_cd_m2": np.full((bins, bins), 1.0).tolist(),
    }
    seen = describe_cell_difference(found, cell)
    assert seen["luminance_ratio"] == pytest.approx(1.25, rel=2e-3)
    residual = np.array(seen["residual"])
    across, along = (
        2 * np.abs(np.mean(residual * np.exp(2j * np.pi * k * place)))
        for k, place in ((1, middle[:, None]), (2, middle[None]))
    )
    assert across < 1e-3
    assert along == pytest.approx(0.01 * np.sinc(2 / bins), abs=1e-3)
    assert seen["residual_rms"] == pytest.approx(0.01 / np.sqrt(2), rel=0.1)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("x,L\n" + "".join(f"{i},{100 + i % 3}\n" for i in range(40)), ("no unit of position",)),
        ("x_mm,L\n" + "".join(f"{i},{-1}\n" for i in range(40)), ("expected above 0",)),
        ("x_mm,L\n0,1\n1,2\n2,1\n", ("3 rows", "16")),
        ("x_mm,L,M\n" + "".join(f"{i},{100},{101}\n" for i in range(40)), ("second luminance",)),
    ],
)
def test_bad_curves_are_refused(tmp_path, content, words):
    path = tmp_path / "l.csv"
    path.write_text(content)
    with pytest.raises(InputError) as error:
        read_curve(path)
    for word in ("l.csv", *words):
        assert word in str(error.value)


def test_bad_images_are_refused(tmp_path):
    path, other = tmp_path / "a.tif", tmp_path / "b.tif"
    tifffile.imwrite(path, np.full((40, 50), 65535, np.uint16))
    tifffile.imwrite(other, np.full((40, 51), 3, np.uint16))
    with pytest.raises(InputError, match=r"2,000 pixels at full scale"):
        read_image(path, Photo(0.1))
    with pytest.raises(InputError, match=r"b.tif: --dark: 51 × 40 pixels: expected 50 × 40"):
        read_image(path, Photo(0.1, dark=other))
    with pytest.raises(InputError, match=r"--crop"):
        read_image(other, Photo(0.1, crop=(0, 0, 52, 40)))


def test_a_flat_curve_has_no_pitch():
    x = np.arange(0.0, 80.0, 0.25)
    value = MEAN + np.random.default_rng(0).normal(0, 5, len(x))
    with pytest.raises(InputError, match="no lamp pitch seen"):
        find_pitch("flat.csv", x, value)
