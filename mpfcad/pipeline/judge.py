"""A measured luminance judged: read, pitch found, contrast by the trace's code, gate, overlay."""

import json
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.errors import InputError
from mpfcad.gate import Gate
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.observed import (
    NAMED_PITCH,
    SAME_PITCH,
    LuminanceImage,
    ObservedPitch,
    Photo,
    check_pitch,
    find_pitch,
    lattice_words,
    observe_cell,
    observe_pitch,
    read_image,
    read_stripes,
    spots_askew_words,
)
from mpfcad.measure.observed.cell import means_of_sides
from mpfcad.measure.observed.image import is_image
from mpfcad.record.judgement import (
    describe_cell_difference,
    describe_difference,
    describe_observed_cell,
    describe_pitch,
    judgement_gate,
)

JUDGEMENT_SCHEMA = 1
#: Cells whose sides differ by more than this share are not the same.
_SAME_SIZE = 0.02
#: A step from pitch to pitch of this share of the luminance's whole range is named.
_TREND = 0.1


@dataclass(frozen=True)
class Judging:
    """How a measurement is judged; lengths in mm.

    Attributes
    ----------
    photo
        how an image becomes luminance; None for a curve
    unit
        of a curve's positions, where its file does not state it
    pitch, lamp
        lamp pitch and a lamp's place; found when None
    cell
        (across, along) of a cell of spots; None: stripes, or found
    spots
        whether cells of spots are looked for
    limit, marginal
        of the contrast; None: of the export compared with, else the thesis's 0.012 and 0.018
    against
        folder of an export
    seed
        of the interval's draws
    """

    photo: Photo | None = None
    unit: str | None = None
    pitch: float | None = None
    lamp: float | None = None
    cell: tuple[float, float] | None = None
    spots: bool = False
    limit: float | None = None
    marginal: float | None = None
    against: Path | None = None
    seed: int = 1


def judge_luminance(path: Path, judging: Judging) -> dict[str, Any]:
    """Return the record of a measured luminance: figures, gate, difference from a prediction.

    Raises
    ------
    InputError
        when the file, or the export, cannot be read, or shows no lamps.
    """
    of_spots = judging.spots or judging.cell is not None
    predicted = None if judging.against is None else _prediction(judging.against, spots=of_spots)
    limit, marginal = _limits(judging, predicted)
    if not path.is_file():
        raise InputError(f"{path}: no such file: expected a luminance curve or image")
    image = None
    if is_image(path):
        if judging.photo is None:
            raise InputError(f"{path}: an image: expected --pixel-mm, the side of a pixel")
        image = read_image(path, judging.photo)
    if of_spots and image is None:
        raise InputError(f"{path}: a curve: expected an image with --spots or --cell-mm")
    if image is not None and of_spots:
        found, contrast = _judge_spots(path, image, judging, predicted)
    else:
        found, contrast = _judge_stripes(path, image, judging, predicted)
    gate = judgement_gate(contrast, limit, marginal)
    return {
        "schema": JUDGEMENT_SCHEMA, "file": path.name, **found,
        "gates": [gate.document()], "verdict": gate.outcome,
    }  # fmt: skip


def _judge_spots(
    path: Path, image: LuminanceImage, judging: Judging, predicted: dict[str, Any] | None
) -> tuple[dict[str, Any], Estimate]:
    """Return the record of an image of spots, and its contrast."""
    try:
        notes = [spots_askew_words(path, image)]
        size = _cell_size(path, image, judging.cell, notes)
        found = observe_cell(image, size, judging.seed)
    except InputError as error:
        raise InputError(lattice_words(path, image) or str(error)) from None
    record = {**_said(notes), "reading": image.reading, **describe_observed_cell(found)}
    if predicted is not None:
        _check_size(judging, found.size, predicted)
        record["against"] = {
            "name": predicted["name"], **describe_cell_difference(found, predicted["cell"]),
            "lamp_mura_contrast": predicted["lamp_mura_contrast"],
        }  # fmt: skip
    return record, found.contrast


def _judge_stripes(
    path: Path, image: LuminanceImage | None, judging: Judging, predicted: dict[str, Any] | None
) -> tuple[dict[str, Any], Estimate]:
    """Return the record of a curve, or of an image of stripes, and its contrast."""
    curve, words = read_stripes(path, image, judging.unit)
    notes = [words]
    pitch = judging.pitch or find_pitch(str(path), curve.position, curve.luminance)
    if judging.pitch is not None:
        notes.append(check_pitch(str(path), curve.position, curve.luminance, pitch))
    seen = observe_pitch(curve, pitch, judging.lamp, judging.seed)
    notes.append(_trend_words(path, seen, None if image is None else judging.photo))
    if predicted is not None:
        notes.append(_check_lamps(path, judging, seen.pitch, predicted))
    record = {**_said(notes), "reading": curve.reading, **describe_pitch(seen)}
    record["pitch_found"] = judging.pitch is None
    if predicted is not None:
        record["against"] = {
            "name": predicted["name"], **describe_difference(seen, predicted["luminance"]),
            "lamp_mura_contrast": predicted["lamp_mura_contrast"],
        }  # fmt: skip
    return record, seen.contrast


def _trend_words(path: Path, seen: ObservedPitch, photo: Photo | None) -> str:
    """Return by how much neighbouring pitches differ, where that counts in the contrast."""
    mean = [seen.curve.mean(i) for i in range(len(seen.each))]
    steps = [
        (abs(b.value - a.value), float(np.hypot(a.standard_error, b.standard_error)))
        for a, b in pairwise(mean)
    ]
    if not steps:
        return ""
    step, error = max(steps)
    share = step / seen.fit.mean.value
    if step < 3 * error or share < _TREND * 2 * seen.contrast.value:
        return ""
    why = "; no flat field was given (--flat)" if photo and photo.flat is None else ""
    return (
        f"{path}: the mean luminance of one lamp pitch and the next differs by up to {share:.2%}, "
        f"as by unequal lamps or a camera's vignetting: that counts in the contrast{why}"
    )


def _said(notes: list[str]) -> dict[str, Any]:
    """Return what is to be said, as an entry of a record, if there is anything."""
    said = [words for words in notes if words]
    return {"notes": said} if said else {}


def _check_lamps(path: Path, judging: Judging, pitch: float, predicted: dict[str, Any]) -> str:
    """Refuse a prediction for lamps of another pitch [mm], and say where they differ a little."""
    quantity = predicted.get("job", {}).get("stack", {}).get("quantity", {})
    given = quantity.get("lamp_pitch_mm", {}).get("value")
    if given is None or abs(pitch / given - 1) <= NAMED_PITCH:
        return ""
    words = f"the file's lamp pitch, {pitch:.5g} mm, is {pitch / given - 1:+.1%} off {given:.5g} mm"
    if abs(pitch / given - 1) <= SAME_PITCH:
        return f"{words} of {predicted['name']}"
    raise InputError(
        f"{path}: {words} of --against {judging.against}: expected lamps of one pitch "
        "(--pitch-mm, --pixel-mm)"
    )


def _prediction(folder: Path, *, spots: bool) -> dict[str, Any]:
    """Return verification.json of an export, or the contrast that `mpfcad measure` wrote."""
    file = folder
    if folder.is_dir():
        files = [folder / name for name in ("verification.json", "measure.json")]
        file = next((each for each in files if each.is_file()), files[0])
    try:
        found = json.loads(file.read_text("utf-8"))
        found = found.get("contrast", found) if file.name == "measure.json" else found
        place = found["cell"]["luminance_cd_m2"] if spots else found["luminance"]["position_pitch"]
        if not place:
            raise KeyError
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        what = "luminance over a cell" if spots else "luminance"
        raise InputError(
            f"{file}: no {what} in it: expected an export of mpfcad run whose film was traced, or "
            f"what mpfcad measure wrote{'' if spots else '; --spots for LEDs'}"
        ) from None
    return {"name": folder.name, **found}


def _check_size(judging: Judging, size: tuple[float, float], predicted: dict[str, Any]) -> None:
    """Refuse a prediction of a cell of another size."""
    given = predicted["cell"]["across_mm"], predicted["cell"]["along_mm"]
    if any(abs(ours / theirs - 1) > _SAME_SIZE for ours, theirs in zip(size, given, strict=True)):
        raise InputError(
            f"--against: {judging.against}: a cell of {given[0]:.4g} × {given[1]:.4g} mm: expected "
            f"{size[0]:.4g} × {size[1]:.4g} mm, that of the image (--cell-mm, --pixel-mm)"
        )


def _limits(judging: Judging, predicted: dict[str, Any] | None) -> tuple[float, float]:
    limit, marginal = 0.012, 0.018
    for gate in predicted.get("gates", ()) if predicted else ():
        if gate["name"] == "lamp_mura_contrast":
            limit, marginal = gate["limit"], gate.get("marginal_limit", gate["limit"])
    limit = limit if judging.limit is None else judging.limit
    marginal = max(marginal, limit) if judging.marginal is None else judging.marginal
    if not 0 < limit <= marginal <= 1:
        raise InputError(f"--limit, --marginal: {limit:g}, {marginal:g}: expected 0 < both ≤ 1")
    return limit, marginal


def _cell_size(
    path: Path, image: LuminanceImage, stated: tuple[float, float] | None, notes: list[str]
) -> tuple[float, float]:
    """Return the pitches across and along: those stated, if the image bears them out, or found.

    What is to be said of them is added to `notes`.
    """
    found = []
    for axis, curve in enumerate(means_of_sides(image)):
        name = f"{path}: {('across', 'along')[axis]}"
        if stated is None:
            found.append(find_pitch(name, *curve, "--cell-mm"))
        else:
            notes.append(check_pitch(name, *curve, stated[axis], "--cell-mm"))
            found.append(stated[axis])
    return found[0], found[1]


def gate_of(record: dict[str, Any]) -> Gate:
    """Return the gate that a record was judged by."""
    gate = record["gates"][0]
    ends = gate["ci95"]
    return Gate(gate["name"], gate["value"], gate["limit"], (ends[0], ends[1]),
                gate["marginal_limit"])  # fmt: skip
