"""Which values a fit seeks: those of the backlight that are not exact and change a case's scene."""

import textwrap
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.backlight.width import limits_of, width_of
from mpfcad.confidence import STEP, Factor, read_covariance
from mpfcad.errors import InputError
from mpfcad.fit import Unknowns, build_unknowns
from mpfcad.job.fit import Fit
from mpfcad.pipeline.fit.case import FitCase
from mpfcad.store import array_hash

#: The lamps' luminance, which scales all luminances: no trace is needed for it.
LUMINANCE = "lamp_luminance_cd_m2"
#: Figures that follow it.
ABSOLUTE = ("luminance", "flux")
#: Its standard uncertainty where none is stated, a share of it: as good as free.
_UNKNOWN = 0.5
#: Characters of a list of names in a message.
_SHOWN = 120


def find_unknowns(
    fit: Fit, file: Path, stack: Stack, cases: dict[str, FitCase]
) -> tuple[Unknowns, dict[str, NDArray[np.bool_]]]:
    """Return the values sought with their priors, and of each case which of them its scene has.

    The lamps' luminance is free unless its width is stated.

    Raises
    ------
    InputError
        when a name is no value that can be sought, or a covariance is none.
    """
    covariance = None if fit.covariance is None else read_covariance(file.parent / fit.covariance)
    stated = {} if covariance is None else dict(
        zip(covariance[0], np.sqrt(np.diag(covariance[1])).tolist(), strict=True)
    )  # fmt: skip
    factors = _factors(stack, stated, set(fit.free))
    names = [factor.name for factor in factors]
    if fit.values is not None:
        asked = {*fit.values, *fit.free, *stated}
        _refuse_unknown(file, asked, names)
        factors = [factor for factor in factors if factor.name in {*asked, LUMINANCE}]
    active = {name: _active(case, factors) for name, case in cases.items()}
    used = [f for i, f in enumerate(factors) if any(row[i] for row in active.values())]
    if not needs_level(fit):
        used = [factor for factor in used if factor.name != LUMINANCE]
    names = [factor.name for factor in used]
    _refuse_unknown(file, {*(fit.values or []), *fit.free, *stated}, names)
    free = set(fit.free)
    if stack.quantity[LUMINANCE].sigma is None:
        free.add(LUMINANCE)
    at = [factors.index(factor) for factor in used]
    try:
        unknowns = build_unknowns(used, free, {LUMINANCE}, covariance)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
    return unknowns, {name: row[at] for name, row in active.items()}


def _refuse_unknown(file: Path, asked: set[str], names: list[str]) -> None:
    wrong = sorted(asked - set(names))
    if wrong:
        known = textwrap.shorten(", ".join(names), _SHOWN, placeholder=" …")
        raise InputError(
            f"{file}: {wrong[0]}: expected values that are not exact and change a case: {known}"
        )


def needs_level(fit: Fit) -> bool:
    """Return whether a measurement states an absolute luminance or flux."""
    return any(
        (one.of in ABSOLUTE and one.over is None) or one.scale_sigma is not None
        for one in fit.measurement
    )


def _factors(stack: Stack, stated: dict[str, float], free: set[str]) -> list[Factor]:
    found = []
    for name, quantity in stack.quantity.items():
        width = width_of(stack, name)
        sigma, source = width.sigma, width.source
        if name in stated:
            sigma, source = stated[name], "covariance"
        if name == LUMINANCE and quantity.sigma is None:
            sigma, source = _UNKNOWN * quantity.value, "free: no prior"
        elif name in free:
            source = "free: no prior"
        if sigma > 0:
            low, high = limits_of(stack, name)
            found.append(Factor(name, quantity.value, sigma, low, high, source))
    return found


def _active(case: FitCase, factors: list[Factor]) -> NDArray[np.bool_]:
    """Return which values change the case's scene, (k,)."""
    plain = array_hash(case.light({}).scene)
    found = []
    for factor in factors:
        if factor.name in case.own:
            found.append(False)
            continue
        step = -STEP if factor.value - STEP * factor.sigma > factor.low else STEP
        value = factor.value + step * factor.sigma
        if not factor.low <= value <= factor.high:
            value = (factor.value + factor.high) / 2
        found.append(array_hash(case.light({factor.name: value}).scene) != plain)
    return np.array(found, bool)
