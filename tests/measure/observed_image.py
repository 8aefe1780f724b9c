"""Images of stripes and of spots of known contrast, with a camera's noise, drawn from a seed."""

import numpy as np

from mpfcad.measure.observed import LuminanceImage, curve_of_image, observe_cell, observe_pitch

_PHASE = np.linspace(0.0, 2 * np.pi, 4001)


def contrast(curve):
    return (curve.max() - curve.min()) / (curve.max() + curve.min())


def stripes(seed):
    """Return the contrast read, and the true one, of one to four pitches, askew or not."""
    rng = np.random.default_rng(seed)
    pixel, pitch, pitches = 0.25, 16.0, int(rng.integers(1, 5))
    turn = np.radians(rng.choice([0.0, rng.uniform(-3, 3)]))
    amplitude, second = rng.uniform(0.005, 0.03), rng.choice([0.0, rng.uniform(0.0, 0.01)])
    lamp, angle = rng.uniform(0.0, pitch), rng.uniform(0.0, 6.3)
    columns = round((pitches + 2) * pitch / pixel)
    x, y = np.meshgrid((np.arange(columns) + 0.5) * pixel, (np.arange(60) + 0.5) * pixel)
    phase = 2 * np.pi * ((x * np.cos(turn) - y * np.sin(turn)) - lamp) / pitch

    def light(phase):
        return 5000 * (1 + amplitude * np.cos(phase) + second * np.cos(2 * phase + angle))

    noise = 5000 * amplitude * rng.uniform(0.1, 2.0)
    image = light(phase) + rng.normal(0, noise, phase.shape)
    found = observe_pitch(curve_of_image(LuminanceImage(image, pixel, "i", turn)), pitch, lamp)
    return found.contrast, contrast(light(_PHASE))


def spots(seed):
    """Return the contrast of the mean cell, and the true one."""
    rng = np.random.default_rng(seed)
    pixel, across, along = 0.5, 16.0, 14.0
    one, two = rng.uniform(0.005, 0.03, 2)
    turn = np.radians(rng.choice([0.0, rng.uniform(-3, 3)]))
    x, y = np.meshgrid((np.arange(160) + 0.5) * pixel, (np.arange(130) + 0.5) * pixel)
    u, v = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
    shift = rng.uniform(0.0, 16.0, 2)

    def light(a, b):
        return 5000 * (1 + one * np.cos(a)) * (1 + two * np.cos(b))

    image = light(2 * np.pi * (u - shift[0]) / across, 2 * np.pi * (v - shift[1]) / along)
    image += rng.normal(0, 5000 * one * rng.uniform(0.1, 1.0), image.shape)
    found = observe_cell(LuminanceImage(image, pixel, "i", turn), (across, along))
    return found.contrast, contrast(light(*np.meshgrid(_PHASE[::20], _PHASE[::20])))
