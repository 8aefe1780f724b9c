"""How films look from above, beside each other on one scale: pictures made from their curves."""

from base64 import b64encode
from collections.abc import Sequence
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.report.drawing.figure import fitted_curve
from mpfcad.report.drawing.picture import HIGH, LOW, MEAN

#: Lamp pitches in a strip, and its size in pixels.
PITCHES, WIDTH, HEIGHT = 3, 384, 64
#: Cells of LEDs along a strip.
ROWS = 2
#: Ends of the scale of deviations, as shares of the mean.
_REACHES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)


def strip_position(pitches: int) -> NDArray[np.float64]:
    """Return the positions of a strip's columns within the pitch, (WIDTH,) float64, 0…1."""
    return (np.arange(WIDTH) + 0.5) / WIDTH * pitches % 1.0


def strip_of(found: dict[str, Any]) -> NDArray[np.float64]:
    """Return the luminance [cd/m²] of a trace on a strip's pixels, (rows, WIDTH) float64.

    One row where nothing changes along the lamps; of a cell of LEDs `ROWS` cells, the fitted
    series of cosines and sines. A pitch of a finite panel stands alone: the next one differs.
    """
    across = strip_position(1 if found.get("judged") else PITCHES)
    if "cell" not in found:
        return fitted_curve(found, across)[None]
    cell = found["cell"]
    height = round(ROWS * WIDTH / PITCHES * cell["along_mm"] / cell["across_mm"])
    along = (np.arange(min(height, 2 * WIDTH)) + 0.5) / height * ROWS % 1.0
    order, fit = np.array(found["fit"]["order"]), np.array(found["fit"]["coefficient_cd_m2"])
    terms = [_terms(place, int(order.max())) for place in (across, along)]
    return np.asarray((terms[1][:, order[:, 1]] * fit) @ terms[0][:, order[:, 0]].T)


def _terms(place: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """Return 1, cos 2πu, sin 2πu, cos 4πu … at places in periods, (k, most + 1) float64."""
    number = np.arange(1, most + 1)
    angle = 2 * np.pi * np.outer(place, (number + 1) // 2)
    wave = np.where(number % 2 == 1, np.cos(angle), np.sin(angle))
    return np.concatenate([np.ones((len(place), 1)), wave], axis=1)


def seen_strip(curve: NDArray[np.float64], white: float) -> str:
    """Return a strip (PNG, base64) in grey: black is 0, `white` [cd/m²] is white.

    The screen's curve of sRGB is applied, so that a monitor shows light in proportion.
    """
    share = np.clip(curve / white, 0, 1)
    coded = np.where(share <= 0.0031308, 12.92 * share, 1.055 * share ** (1 / 2.4) - 0.055)
    return _png(_high(np.rint(coded * 255).astype(np.uint8)))


def deviation_strip(curve: NDArray[np.float64], reach: float) -> str:
    """Return a strip (PNG, base64) of what is above (brown) and below (blue) the curve's mean."""
    share = np.clip((curve / curve.mean() - 1) / reach, -1, 1)
    return _png(_high(shade(share)))


def _high(rows: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a strip as high as it is drawn: a single row many times."""
    return np.repeat(rows, HEIGHT, axis=0) if len(rows) == 1 else rows


def shade(share: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the colours, (…, 3) uint8, of deviations from -1 to 1."""
    ends = np.where(share[..., None] < 0, LOW, HIGH)
    return np.rint(MEAN + np.abs(share)[..., None] * (ends - MEAN)).astype(np.uint8)


def scale_strip() -> str:
    """Return the scale of deviations (PNG, base64), below the mean at the left."""
    ramp = shade(np.linspace(-1, 1, WIDTH))
    return _png(np.repeat(ramp[None], 10, axis=0))


def common_reach(curves: Sequence[NDArray[np.float64]]) -> float:
    """Return the least end of the scale that holds every curve's deviation from its mean."""
    most = max(float(np.abs(curve / curve.mean() - 1).max()) for curve in curves)
    return next((reach for reach in _REACHES if reach >= most), most)


def _png(pixels: NDArray[np.uint8]) -> str:
    from PIL import Image

    buffer = BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG", compress_level=9)
    return b64encode(buffer.getvalue()).decode("ascii")
