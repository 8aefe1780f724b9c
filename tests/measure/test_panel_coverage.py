"""Coverage on finite panels: the worst pitch's interval holds it in 93 to 97 % of many small runs.

Each scene is traced 400 times (seeds 5000 … 5399) with four nets of 1024 paths a point. A count of
400 scatters by 1.1 %, so 400 runs tell 93 … 97 % from less than 89.8 % and from more than 99.1 %
(2.5 sigma each).
"""

import numpy as np
import pytest
from harness import film_file, groove

from mpfcad.backlight import read_stack
from mpfcad.measure import contrast_of_curve, fit_curve, light_film
from mpfcad.measure.judged import judged_pitches
from mpfcad.measure.meter import pitch_positions
from mpfcad.optics.engine import trace
from mpfcad.optics.source import EYE, Source

RUNS, BLOCKS, THICKNESS = 400, 4, 14.0
SHEETS = {"extent": "panel", "panel_width_mm": 133.2, "lamp_count": 4, "rim_mm": 0.0}
BARE = 'layers = ["clear_plate", "film"]\n'
UNEQUAL = ((1, 0.95), (2, 1.05), (4, 0.9))
SCENES = {
    "equal": ("", SHEETS),
    "dimmed": ("", SHEETS | {"lamp_3_luminance_factor": 0.9}),
    "unequal": ("", SHEETS | {f"lamp_{i}_luminance_factor": f for i, f in UNEQUAL}),
    "dark pitch": ("", SHEETS | {f"lamp_{i}_luminance_factor": 0.0 for i in (2, 3)}),
    "shifted": ("", SHEETS | {"lamp_2_shift_mm": 2.0}),
    "one lamp": ("", SHEETS | {"lamp_count": 1}),
    "no sheets": (BARE, SHEETS),
    "no sheets, one lamp": (BARE, SHEETS | {"lamp_count": 1, "reflector_specular_fraction": 0.0}),
}


def lit_scene(folder, name):
    layers, values = SCENES[name]
    stack = folder / "stack.toml"
    stack.write_text(f'extends = "thesis-32in-mpf"\n{layers}')
    film = film_file(folder / "film.stl", [groove(60.0)] * 20, base=0.2)
    return light_film(read_stack(stack, THICKNESS, values), film)


def worst_contrast(pitches):
    """Return the largest contrast of pitches (w, m)."""
    high, low = pitches.max(axis=1), pitches.min(axis=1)
    return float(np.max((high - low) / (high + low)))


def held_on(lit, runs):
    """Return how each run's interval lies (1 too high, -1 too low), the truth, and the intervals.

    All runs together stand for the truth: their error is 20 times smaller than that of one.
    """
    position = pitch_positions(lit.stack)
    judged = judged_pitches(lit.stack, position)
    assert judged.stop - judged.first == judged.count
    source = Source(
        EYE, position * lit.stack.period.across, lit.spot.width, acceptance=lit.stack.acceptance
    )
    found = [trace(lit.scene, source, BLOCKS, seed=5000 + i) for i in range(runs)]
    total = found[0]
    for tally in found[1:]:
        total = total + tally
    fits = [
        fit_curve(
            position,
            t.radiance,
            t.radiance_error,
            t.blocks,
            periodic=False,
            blurred=lit.is_blurred,
        )
        for t in (*found, total)
    ]
    whole = fits.pop()
    truth = worst_contrast(whole.curve[whole.window])
    # The points alone, without any curve, tell the same but for their own noise.
    number = np.arange(judged.count)[:, None] * 32 + np.arange(33)
    error = float(np.max(whole.error / whole.luminance))
    assert abs(truth - worst_contrast(whole.luminance[number])) < 3 * error
    every = [contrast_of_curve(f, i) for i, f in enumerate(fits)]
    return np.array([(one.low > truth) - (one.high < truth) for one in every]), truth, every


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_the_interval_of_a_panels_worst_pitch_holds_it(tmp_path, name):
    lit = lit_scene(tmp_path, name)
    side, truth, every = held_on(lit, RUNS)
    share = np.mean(side == 0)
    half = np.median([one.half_width for one in every])
    print(
        f"{name}: contrast {truth:.4f} ± {half:.4f}: {share:.4f} of {RUNS} held, "
        f"{np.sum(side > 0)} too high, {np.sum(side < 0)} too low"
    )
    # Of several pitches noise makes one the worst: intervals miss on one side only.
    most = 0.97 if lit.stack.source.count == 1 else 0.975
    assert share >= 0.93 - 2.5 * np.sqrt(0.93 * 0.07 / RUNS)
    assert share <= most + 2.5 * np.sqrt(most * (1 - most) / RUNS)
