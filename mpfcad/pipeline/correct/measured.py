"""The luminance that was measured of a print, over the lamp pitch of its backlight."""

from pathlib import Path

from mpfcad.design.reprint import Seen
from mpfcad.errors import InputError
from mpfcad.measure.observed import (
    ObservedPitch,
    askew_words,
    check_pitch,
    curve_of_image,
    observe_pitch,
    read_curve,
)
from mpfcad.measure.observed.image import is_image, read_image
from mpfcad.pipeline.judge import Judging
from mpfcad.pipeline.progress import SILENT, Progress

#: A stated lamp pitch may be off the backlight's by so much: the scale of a file.
_SAME_PITCH = 0.05
_HARMONICS = 4


def observe_print(
    measured: Path, judging: Judging, pitch: float, progress: Progress = SILENT
) -> ObservedPitch:
    """Return what was measured of a print over the lamp pitch [mm] of its backlight.

    Raises
    ------
    InputError
        when the file cannot be read, or bears another period.
    """
    if not measured.is_file():
        raise InputError(f"{measured}: no such file: expected a luminance curve or image")
    if is_image(measured):
        if judging.photo is None:
            raise InputError(f"{measured}: an image: expected --pixel-mm, the side of a pixel")
        image = read_image(measured, judging.photo)
        curve = curve_of_image(image)
        words = askew_words(measured, image, curve)
        if words:
            progress.note(f"{measured}: {words}")
    else:
        curve = read_curve(measured, judging.unit)
    own = judging.pitch or pitch
    if abs(own / pitch - 1) > _SAME_PITCH:
        raise InputError(
            f"--pitch-mm: {own:g}: expected the lamp pitch of the print's backlight, {pitch:g} mm, "
            f"within {_SAME_PITCH:.0%}"
        )
    whose = "--pitch-mm" if judging.pitch else "the lamp pitch in mm of the print's backlight,"
    words = check_pitch(
        str(measured), curve.position, curve.luminance, own, whose, "a curve of that backlight"
    )
    if words:
        progress.note(f"{measured}: {words}")
    return observe_pitch(curve, own, judging.lamp, judging.seed)


def seen_of(found: ObservedPitch) -> Seen:
    """Return the cosines of a measurement; its sines are the film's misplacement, not the map's."""
    fit = found.fit
    mean = float(fit.coefficient[0])
    cosines = slice(1, 2 * _HARMONICS, 2)
    return Seen(mean, fit.coefficient[cosines] / mean, fit.covariance[cosines, cosines] / mean**2)
