"""A stylus trace from a file of any kind, and the line that says what was understood."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary import TEXT_LIMIT, reads
from mpfcad.errors import InputError
from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.file.column import find_profile
from mpfcad.film.stylus.file.instrument_file import is_instrument_file, read_instrument_file
from mpfcad.film.stylus.file.profile import RawProfile, tidy
from mpfcad.film.stylus.file.scale import (
    FLATTEST,
    MOST_RELIEF,
    SHOWN,
    fitting_units,
    read_shape,
    relief_of,
)
from mpfcad.film.stylus.file.text import read_table
from mpfcad.film.stylus.file.unit import UNITS, WORDS, parse_unit
from mpfcad.film.stylus.residual import SAID
from mpfcad.film.stylus.tip import StylusTip
from mpfcad.film.stylus.trace import StylusTrace, check_sampling
from mpfcad.film.stylus.upright import Lie, lie_of
from mpfcad.units import deg, um

#: Bytes in which a binary file shows that it is one: some begin with pages of text.
_HEADER = 100_000
#: Share of the misfit that heights in another unit must come down to.
_CLEARLY = 0.6


@dataclass(frozen=True)
class ReadingOption:
    """What a user states over what a file says.

    Attributes
    ----------
    units
        of position and height, keys of `UNITS`
    columns
        of position and height, from 1
    correct
        whether sign and unit are set right by pitch and depth, instead of refused
    tip
        the stylus's
    upright
        whether heights are known to have the tips up, so that it is not asked
    own_shape
        whether the shape is taken as measured: then a meniscus that is no parabola is a groove's
        where tips up leaves the less
    """

    units: tuple[str, str] | None = None
    columns: tuple[int, int] | None = None
    correct: bool = False
    tip: StylusTip | None = None
    upright: bool = False
    own_shape: bool = False


def parse_units(text: str) -> tuple[str, str]:
    """Return the units of position and height that `um` or `mm,um` names.

    Raises
    ------
    InputError
        naming the option when a word is no unit.
    """
    words = text.split(",")
    if len(words) > 2:
        raise InputError(f"--unit: {text!r}: expected one unit, or X,Z")
    try:
        names = [parse_unit(word) for word in words]
    except ValueError as error:
        raise InputError(f"--unit: {error}") from None
    return names[0], names[-1]


def parse_columns(text: str) -> tuple[int, int]:
    """Return the columns of position and height, from 1, that `X,Z` names.

    Raises
    ------
    InputError
        naming the option.
    """
    try:
        x, z = (int(word) for word in text.split(","))
    except ValueError:
        raise InputError(f"--columns: {text!r}: expected X,Z, two whole numbers") from None
    return x, z


@reads("a stylus trace", TEXT_LIMIT)
def read_stylus_trace(
    path: Path,
    groove: Groove,
    prism_widths: int = 2,
    option: ReadingOption | None = None,
    profile: Profile = "filled",
) -> StylusTrace:
    """Read a stylus trace from a text file or an instrument's, [mm], tips up, x increasing.

    Delimiter, decimal mark, encoding, columns, units, direction and tip come from the file, and
    are stated in the trace's `reading`. Pitch and depth check the scale.

    Raises
    ------
    InputError
        one line with file, row, value and what was expected; where two readings fit, both.
    """
    path, option = Path(path), option or ReadingOption()
    if not path.is_file():
        raise InputError(f"{path}: no such file: expected a stylus trace")
    raw = tidy(path, _read_raw(path, option))
    try:
        return _scaled(path, raw, groove, prism_widths, option, profile)
    except InputError as error:
        read = ", ".join(raw.words)
        raise InputError(f"{error} (read as {read}, {len(raw.position):,} points)") from None


def _scaled(
    path: Path,
    raw: RawProfile,
    groove: Groove,
    prism_widths: int,
    option: ReadingOption,
    profile: Profile,
) -> StylusTrace:
    """Return the trace in mm, tips up, once its units and its scale are known."""
    if len(raw.position) < 8:
        raise InputError(f"{path}: {len(raw.position)} rows: expected 40 or more")
    raw, said = _with_units(path, raw, option, groove, profile)
    x = raw.position * UNITS[str(raw.position_unit)]
    z = raw.height * UNITS[str(raw.height_unit)]
    try:
        check_sampling(path, x, list(raw.lines or []), groove.pitch, prism_widths)
    except InputError:
        _refuse_other_position(path, raw, groove, profile)
        raise
    tip = option.tip or raw.tip
    z, corrected, either = _upright(path, x, z, replace(raw, tip=tip), option, groove, profile)
    words = [*raw.words[:1], said, *raw.words[1:], f"{len(x):,} points"]
    words += [corrected] if corrected else []
    words.append(_tip_words(tip, option.tip is not None))
    return StylusTrace(x, z, path.name, tip, f"read {path.name}: {', '.join(words)}", either)


def _read_raw(path: Path, option: ReadingOption) -> RawProfile:
    with path.open("rb") as file:
        start = file.read(_HEADER)
    if is_instrument_file(path, start):
        return read_instrument_file(path)
    return find_profile(path, read_table(path), option.columns)


def _with_units(
    path: Path, raw: RawProfile, option: ReadingOption, groove: Groove, profile: Profile
) -> tuple[RawProfile, str]:
    """Return the profile with both units known, and how they are."""
    if option.units is not None:
        x, z = option.units
        return replace(raw, position_unit=x, height_unit=z), _pair(x, z) + " as told"
    if raw.strange:
        raise InputError(
            f"{path}: {raw.strange}: expected one of length: {WORDS}; --unit X,Z overrules it"
        )
    if raw.position_unit and raw.height_unit:
        return raw, _pair(raw.position_unit, raw.height_unit)
    pairs = fitting_units(raw.position, raw.height, groove, profile, option.tip or raw.tip)
    stated = (raw.position_unit, raw.height_unit)
    pairs = [p for p in pairs if all(s in (None, own) for s, own in zip(stated, p, strict=True))]
    if len(pairs) != 1:
        readings = " or ".join(_pair(*pair) for pair in pairs) or "no unit"
        raise InputError(
            f"{path}: no unit stated{_one_stated(stated)}, and of µm, mm, nm, Å and m {readings} "
            f"shows grooves of pitch {groove.pitch / um:g} µm and depth {groove.depth / um:g} µm: "
            "expected a header with units, or --unit X,Z"
        )
    x, z = pairs[0]
    return (
        replace(raw, position_unit=x, height_unit=z),
        f"{_pair(x, z)} by pitch and depth (not stated)",
    )


def _refuse_other_position(path: Path, raw: RawProfile, groove: Groove, profile: Profile) -> None:
    """Refuse positions that are too short, or too coarse, by their unit alone, naming both.

    Raises
    ------
    InputError
        when in another unit of the positions the trace shows the grooves.
    """
    pairs = fitting_units(raw.position, raw.height, groove, profile, raw.tip)
    other = [x for x, z in pairs if z == raw.height_unit and x != raw.position_unit]
    if len(other) == 1:
        length = (raw.position[-1] - raw.position[0]) * UNITS[str(raw.position_unit)] / um
        raise InputError(
            f"{path}: x in {raw.position_unit} is {length:.4g} µm long; in {other[0]} there are "
            f"grooves of pitch {groove.pitch / um:g} µm: expected --unit "
            f"{_option((other[0], str(raw.height_unit)))}, or a trace of that length"
        )


def _pair(x: str, z: str) -> str:
    return x if x == z else f"x {x} and z {z}"


def _one_stated(stated: tuple[str | None, str | None]) -> str:
    return "".join(f" (but {axis} {unit})" for axis, unit in zip("xz", stated, strict=True) if unit)


def _upright(
    path: Path,
    x: NDArray[np.float64],
    z: NDArray[np.float64],
    raw: RawProfile,
    option: ReadingOption,
    groove: Groove,
    profile: Profile,
) -> tuple[NDArray[np.float64], str, bool]:
    """Return heights of the right sign and size, what was corrected, and if they may lie over.

    Raises
    ------
    InputError
        naming what is wrong, unless it shall be corrected; where no reading fits, both.
    """
    if read_shape(x, z, groove, profile, raw.tip).explained < SHOWN:
        other = _other_units(raw, groove, profile)
        if other:
            raise InputError(
                f"{path}: no grooves of pitch {groove.pitch / um:g} µm with positions in "
                f"{raw.position_unit}; as {other} there are: expected --unit {_option(other)}"
            )
    lie = lie_of(x, z, groove, profile, raw.tip)
    faults: list[str] = []
    size = relief_of(x, z)
    if lie.share > 0 or not size > FLATTEST * groove.depth:
        factor, words, scaled = _height_factor(x, z, raw, groove, profile, lie)
        if words:
            if not (factor and option.correct):
                raise InputError(
                    f"{path}: relief {size / um:.4g} µm with z in {raw.height_unit}, depth "
                    f"{groove.depth / um:g} µm: {words}: expected heights of the grooves; "
                    + (f"--correct takes them times {factor:g}, or --unit says it" if factor else
                       "is --depth-um right, and z in its unit?")
                )  # fmt: skip
            z, lie = z * factor, scaled or lie
            faults.append(words)
    if option.upright:
        return z, ", ".join(f"{fault} (corrected)" for fault in faults), False
    if lie.way == "neither" and not (option.own_shape and lie.leans_up):
        raise InputError(
            f"{path}: z shows no grooves of pitch {groove.pitch / um:g} µm and depth "
            f"{groove.depth / um:g} µm: {lie.words}: expected one that leaves {SAID:.1%} or less"
        )
    if lie.way == "down":
        if not option.correct:
            raise InputError(
                f"{path}: z upside down: {lie.words}: expected tips up: --correct turns it, "
                "--upright keeps it, or is it a mould's trace?"
            )
        z = -z
        faults.insert(0, "z upside down")
    return z, ", ".join(f"{fault} (corrected)" for fault in faults), lie.way == "either"


def _height_factor(
    x: NDArray[np.float64], z: NDArray[np.float64], raw: RawProfile, groove: Groove,
    profile: Profile, as_stated: Lie,
) -> tuple[float, str, Lie | None]:  # fmt: skip
    """Return by what heights must be multiplied to be the grooves', why, and how they lie then.

    The factor is 0 where none is, or several are; the words are empty where heights have the
    grooves' size, and fit as stated as well as in any other.
    """
    size = relief_of(x, z)
    lowest, highest = FLATTEST * groove.depth, groove.depth * MOST_RELIEF[profile]
    fits = []
    for factor in (1e-4, 1e-3, 1e-1, 1e1, 1e3, 1e4):
        if lowest < size * factor < highest:
            lie = lie_of(x, z * factor, groove, profile, raw.tip)
            whole = lie.share == 0 < as_stated.share
            if lie.fits and (whole or lie.misfit < _CLEARLY * factor * as_stated.misfit):
                fits.append((factor, lie))
    if len(fits) != 1:
        if lowest < size < highest and (not fits or as_stated.fits):
            return 0.0, "", None
        reading = " or ".join(f"{factor:g}" for factor, _ in fits)
        return 0.0, f"z is not in that unit{': times ' + reading if reading else ''}", None
    factor, lie = fits[0]
    unit = UNITS[str(raw.height_unit)] * factor
    names = [name for name, each in UNITS.items() if abs(each / unit - 1) < 1e-9]
    what = f"z is in {names[0]}" if names else f"z is {1 / factor:g} times its size"
    return factor, what, lie


def _other_units(raw: RawProfile, groove: Groove, profile: Profile) -> tuple[str, str] | None:
    pairs = fitting_units(raw.position, raw.height, groove, profile, raw.tip)
    return pairs[0] if len(pairs) == 1 else None


def _option(pair: tuple[str, str]) -> str:
    return ",".join({"µm": "um", "Å": "A", "µin": "uin"}.get(unit, unit) for unit in pair)


def _tip_words(tip: StylusTip | None, told: bool) -> str:
    if tip is None:
        return "tip not stated"
    angle = f", {tip.angle / deg:g}°"
    off = f" ± {tip.radius_off / um:g}" if tip.radius_off else ""
    return f"tip {tip.radius / um:g}{off} µm{angle} {'as told' if told else 'from its header'}"
