"""The luminance that was measured of a print, over the lamp pitch of its backlight."""

from pathlib import Path

from mpfcad.design.reprint import Seen
from mpfcad.errors import InputError
from mpfcad.measure.observed import (
    SAME_PITCH,
    ObservedPitch,
    check_pitch,
    observe_pitch,
    read_image,
    read_stripes,
)
from mpfcad.measure.observed.image import is_image
from mpfcad.pipeline.judge import Judging
from mpfcad.pipeline.progress import SILENT, Progress

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
    image = None
    if is_image(measured):
        if judging.photo is None:
            raise InputError(f"{measured}: an image: expected --pixel-mm, the side of a pixel")
        image = read_image(measured, judging.photo)
    curve, words = read_stripes(measured, image, judging.unit)
    if words:
        progress.note(f"{measured}: {words}")
    own = judging.pitch or pitch
    if abs(own / pitch - 1) > SAME_PITCH:
        raise InputError(
            f"--pitch-mm: {own:g}: expected the lamp pitch of the print's backlight, {pitch:g} mm, "
            f"within {SAME_PITCH:.0%}"
        )
    whose = "--pitch-mm" if judging.pitch else "the lamp pitch in mm of the print's backlight,"
    words = check_pitch(
        str(measured), curve.position, curve.luminance, own, whose, "a curve of that backlight"
    )
    if words:
        progress.note(f"{measured}: {words}")
    return observe_pitch(curve, own, judging.lamp, judging.seed)


def seen_of(found: ObservedPitch) -> Seen:
    """Return the cosines of a measurement."""
    return Seen(float(found.fit.coefficient[0]), *found.cosines(_HARMONICS))
