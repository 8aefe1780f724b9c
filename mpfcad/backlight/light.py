"""The table `[light]` of a stack file: polarisation, bands, the lamps' spectrum."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpfcad.errors import InputError
from mpfcad.spectrum import DISPERSION, LEAST, MOST, Bands, Spectrum, read_spectrum, weighs_only

_KEYS = ("polarised", "bands", "spectrum", "dispersion")
#: Where bands lie that are asked for by their number [nm].
_FIRST, _LAST = 400.0, 700.0
_LOWEST, _HIGHEST = 360.0, 830.0
#: Bands nearer than this [nm] have no spectrum of their own.
_LEAST_STEP = 1.0


@dataclass(frozen=True)
class Light:
    """What a stack says of its light; None where it says nothing."""

    polarised: bool = False
    bands: tuple[float, ...] | None = None
    spectrum: Spectrum | None = None
    dispersion: str = "traced"


def read_light(where: str, folder: Path | None, entry: object, base: Light) -> Light:
    """Return the light of a table on top of what a stack extends; spectra lie beside `folder`.

    Raises
    ------
    InputError
        naming the key, the value and what was expected.
    """
    if not isinstance(entry, Mapping) or set(entry) - set(_KEYS):
        raise InputError(f"{where}: {entry!r}: expected a table with {', '.join(_KEYS)}")
    polarised = entry.get("polarised", base.polarised)
    if not isinstance(polarised, bool):
        raise InputError(f"{where}.polarised: {polarised!r}: expected true or false")
    dispersion = entry.get("dispersion", base.dispersion)
    if dispersion not in DISPERSION:
        raise InputError(f"{where}.dispersion: {dispersion!r}: expected {' or '.join(DISPERSION)}")
    bands, spectrum = base.bands, base.spectrum
    if "bands" in entry:
        bands = _bands(f"{where}.bands", entry["bands"])
    if "spectrum" in entry:
        spectrum = read_spectrum(f"{where}.spectrum", folder, entry["spectrum"])
    if (bands is None) != (spectrum is None):
        given, needs = ("bands", "spectrum") if spectrum is None else ("spectrum", "bands")
        raise InputError(f"{where}.{needs}: missing: expected with {given}")
    if bands is None and "dispersion" in entry:
        raise InputError(f"{where}.dispersion: needs bands and spectrum")
    return Light(polarised, bands, spectrum, dispersion)


def _bands(where: str, entry: object) -> tuple[float, ...]:
    """Return the bands' wavelengths [nm]: those of a list, or so many from 400 to 700 nm."""
    expected = f"{LEAST} … {MOST} rising wavelengths in nm, or their number"
    if isinstance(entry, int) and not isinstance(entry, bool):
        if not LEAST <= entry <= MOST:
            raise InputError(f"{where}: {entry}: expected {LEAST} … {MOST} bands")
        return tuple(_FIRST + i * (_LAST - _FIRST) / (entry - 1) for i in range(entry))
    if not isinstance(entry, list):
        raise InputError(f"{where}: {entry!r}: expected {expected}")
    if not LEAST <= len(entry) <= MOST:
        raise InputError(f"{where}: {len(entry)} bands: expected {expected}")
    before = _LOWEST - _LEAST_STEP
    for at, one in enumerate(entry, 1):
        least = before + _LEAST_STEP
        number = isinstance(one, int | float) and not isinstance(one, bool)
        if not number or not least <= one <= _HIGHEST:
            raise InputError(
                f"{where}: entry {at}: {one!r}: expected a wavelength in {least:g} … {_HIGHEST:g}"
            )
        before = float(one)
    return tuple(map(float, entry))


def refuse_uncovered(where: str, bands: tuple[float, ...], spectrum: Spectrum) -> None:
    """Raise unless a spectrum is stated from the first band to the last.

    Raises
    ------
    InputError
        naming what it covers.
    """
    if not (spectrum.first <= bands[0] and bands[-1] <= spectrum.last):
        raise InputError(
            f"{where}: {spectrum.first:g} … {spectrum.last:g} nm: does not cover the bands, "
            f"{bands[0]:g} … {bands[-1]:g} nm: expected a spectrum that does"
        )


def build_bands(
    where: str,
    light: Light,
    emission: dict[str, Spectrum],
    value: dict[str, tuple[float, ...]],
) -> Bands | None:
    """Return the bands of a stack; None where it states none.

    `emission` is that of each converting layer; `value` what of the stack differs at the bands.

    Raises
    ------
    InputError
        when a spectrum does not cover the bands, or dispersion meets a layer that converts light.
    """
    if light.bands is None or light.spectrum is None:
        if emission:
            name = next(iter(emission))
            raise InputError(f"{where}: layers: {name}: converter: needs light.bands and spectrum")
        return None
    refuse_uncovered(f"{where}: light.spectrum", light.bands, light.spectrum)
    for name, spectrum in emission.items():
        refuse_uncovered(f"{where}: layers: {name}.emission", light.bands, spectrum)
    neglected: tuple[str, ...] = ()
    if light.dispersion == "neglected":
        neglected = tuple(key for key in value if not weighs_only(key))
        value = {key: found for key, found in value.items() if weighs_only(key)}
    bands = Bands(light.bands, light.spectrum, light.dispersion, emission, value, neglected)
    if bands.separate and emission:
        raise InputError(
            f"{where}: light.dispersion: {bands.separate[0]} depends on the wavelength and "
            f"{next(iter(emission))} converts light: expected dispersion = 'neglected'"
        )
    return bands


def light_inputs(bands: Bands | None, flat: list[str]) -> list[dict[str, Any]]:
    """Return how light is traced, as inputs {name, value, tag, source}; `flat` is alike at all."""
    if bands is None:
        return []
    listed = ", ".join(f"{one:.4g}" for one in bands.wavelength)
    inputs = [{"name": "light.bands", "value": listed, "tag": "given", "source": "nm"}]
    spectra = {"light.spectrum": bands.spectrum}
    spectra |= {f"{name}.emission": one for name, one in bands.emission.items()}
    inputs += [
        {"name": name, "value": one.title, "tag": one.tag, "source": one.source}
        for name, one in spectra.items()
    ]
    if bands.dispersion == "neglected":
        said = f"neglected: {', '.join(bands.neglected) or 'none is stated'}"
    else:
        said = (
            f"each band traced: {', '.join(bands.separate)}"
            if bands.separate
            else "no dispersion stated"
        )
    inputs.append(
        {"name": "light.dispersion", "value": bands.dispersion, "tag": "given", "source": said}
    )
    if flat:
        inputs.append({"name": "light.flat", "value": f"{len(flat)} values", "tag": "assumed",
                       "source": f"the same at all bands: {', '.join(flat)}"})  # fmt: skip
    return inputs


def describe_bands(bands: Bands) -> dict[str, Any]:
    """Return the bands as plain values; `restore_bands` makes the same of them."""
    return {
        "wavelength_nm": list(bands.wavelength),
        "spectrum": _describe(bands.spectrum),
        "dispersion": bands.dispersion,
        "emission": [[name, _describe(one)] for name, one in bands.emission.items()],
        "value": {name: list(values) for name, values in bands.value.items()},
        "neglected": list(bands.neglected),
    }


def restore_bands(document: Mapping[str, Any] | None) -> Bands | None:
    """Return the bands that `describe_bands` has described."""
    if document is None:
        return None
    return Bands(
        tuple(document["wavelength_nm"]), _restore(document["spectrum"]), document["dispersion"],
        {name: _restore(one) for name, one in document["emission"]},
        {name: tuple(values) for name, values in document["value"].items()},
        tuple(document["neglected"]),
    )  # fmt: skip


def _describe(spectrum: Spectrum) -> dict[str, Any]:
    return {**vars(spectrum), "power": list(spectrum.power)}


def _restore(document: Mapping[str, Any]) -> Spectrum:
    return Spectrum(**{**document, "power": tuple(document["power"])})
