"""The groove's shape from a stylus trace: levelled, centred, its tip undone, with intervals.

The meniscus may have any shape between parabola and circle, and meet the walls anywhere. C is the
curvature of the parabola *through the tips* that has the same fill, `fitted_curvature` that of the
least-squares parabola over its groove (Hsieh, MPF thesis); both are names of the fill fraction,
which alone does not depend on the scale of positions and heights.

A trace whose pitch or wall slope is a few percent off what was stated has two readings: the film is
so, or the instrument's scale is. The interval of C holds both (Imbens and Manski, "Confidence
intervals for partially identified parameters", Econometrica 72, 1845, 2004).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.bound.interval import (
    HIDDEN_WORDS,
    Interval,
    Scaled,
    as_read,
    curvature_interval,
    fill_interval,
    hidden_slope,
    joined,
    on_stated_scale,
    slope_hidden,
)
from mpfcad.film.stylus.bound.spread import Spread, spread_of
from mpfcad.film.stylus.misfit import GrooveNumbers, check_shape, odd_grooves
from mpfcad.film.stylus.model import PITCH, TraceModel
from mpfcad.film.stylus.shape import MeniscusShape, meniscus_shape
from mpfcad.film.stylus.solve import Fitted, fit_model
from mpfcad.film.stylus.tip import StylusTip
from mpfcad.film.stylus.tips import fits_of_tips, left_as_read
from mpfcad.film.stylus.trace import StylusTrace
from mpfcad.units import um

#: Departures of pitch and slope, as shares: named from here, and refused from there.
NAMED, REFUSED = 0.01, 0.08
#: Prism widths that are fitted at most.
MOST_WIDTHS = 40


@dataclass(frozen=True, eq=False)
class StylusFit:
    """What a trace says about the groove; lengths in mm.

    Attributes
    ----------
    curvature
        C [1/mm] of the parabola through the tips that has the fill
    fitted_curvature
        of the least-squares parabola over the whole groove [1/mm]
    fill_fraction
        resin's share of the groove's area
    residual_rms, fitted_residual_rms
        of the groove's profile, and of the parabola
    tilt
        slope of the trace's base line
    centre
        position of a groove's centre
    position, height
        (n,) float64, the heights used: x from the nearest groove's centre, -w … w of the stated
        pitch, and the levelled height above the bare groove's valley, the tip still in it
    surface
        (n,) float64, the fitted groove itself at the same places
    tip
        the one that was undone; None: sharp
    pitch, depth
        as the trace shows them
    grooves
        how many prism widths were used
    meniscus
        the shape of the resin's surface; None: a mould's parabola
    notes
        what a reader should know, one sentence each
    heights_off
        how far the walls are off the stated depth's slope, in words; empty where they are not
    """

    curvature: Interval
    fitted_curvature: Interval
    fill_fraction: Interval
    residual_rms: float
    fitted_residual_rms: float
    tilt: float
    centre: float
    position: NDArray[np.float64]
    height: NDArray[np.float64]
    surface: NDArray[np.float64]
    tip: StylusTip | None
    pitch: float
    depth: float
    grooves: int
    meniscus: MeniscusShape | None
    notes: tuple[str, ...]
    heights_off: str = ""


def fit_stylus_trace(
    trace: StylusTrace,
    groove: Groove,
    profile: Profile = "filled",
    prism_widths: int | None = None,
    *,
    correct: bool = False,
) -> StylusFit:
    """Fit the middle `prism_widths` prism widths of a trace, or all whole ones, up to 40.

    `correct`: pitch and slope that are off are the instrument's scale, and put right.

    Raises
    ------
    InputError
        when the trace does not show grooves of this pitch and depth.
    """
    if not np.all(np.isfinite(trace.height)):
        raise InputError(f"{trace.name}: z_um: nan or inf among the heights: expected numbers")
    options = (groove, profile, prism_widths, correct)
    if not trace.either:
        return _fit_upright(trace, *options)
    found, errors = [], []
    for each in (trace, trace.turned()):
        try:
            found.append(_fit_upright(each, *options))
        except InputError as error:
            errors.append(error)
    if not found:
        raise errors[0]
    return found[0] if len(found) == 1 else _of_both_ways(trace, *found)


def _of_both_ways(trace: StylusTrace, up: StylusFit, down: StylusFit) -> StylusFit:
    """Return the upright fit of a trace that may as well lie upside down; its intervals hold both.

    Raises
    ------
    InputError
        when the two contradict each other.
    """
    if max(up.curvature.low, down.curvature.low) > min(up.curvature.high, down.curvature.high):
        one, other = (
            f"C = {fit.curvature.value:.4g} [{fit.curvature.low:.4g}, {fit.curvature.high:.4g}] /mm"
            for fit in (up, down)
        )
        may = "" if trace.tip else "--tip-radius-um, which may tell, or "
        raise InputError(
            f"{trace.name}: z_um: tips up, {one}, and upside down, {other}, fit alike: expected "
            f"{may}--upright once the sign of z is right"
        )
    note = "upside down the trace would fit as well: the interval holds both readings"
    return replace(
        up,
        curvature=joined([up.curvature, down.curvature]),
        fitted_curvature=joined([up.fitted_curvature, down.fitted_curvature]),
        fill_fraction=joined([up.fill_fraction, down.fill_fraction]),
        notes=(*up.notes, note),
    )


def _fit_upright(
    trace: StylusTrace, groove: Groove, profile: Profile, prism_widths: int | None, correct: bool
) -> StylusFit:
    """Fit a trace whose tips are up."""
    widths = prism_widths or min(max(trace.widths(groove.pitch), 1), MOST_WIDTHS)
    used = trace.middle(widths * groove.pitch)
    middle = float(np.mean(used.position))

    def fitting(part: StylusTrace) -> Callable[..., Fitted]:
        def fitted(tip: StylusTip | None, x_part: float = 1.0, z_part: float = 1.0) -> Fitted:
            x, z = (part.position - middle) / x_part, part.height / z_part
            return fit_model(TraceModel.of(x, z, groove, profile, tip, widths))

        return fitted

    fitted = fitting(used)
    tips = fits_of_tips(trace, fitted)
    first = tips.fits[0]
    numbers = GrooveNumbers.of(trace, first, middle)
    odd = odd_grooves(used, first, lambda part: fitting(part)(first.model.tip), numbers)
    if odd is not None:
        fitted = fitting(odd.rest)
        tips = fits_of_tips(trace, fitted)
    fits, best = tips.fits, tips.fits[0]
    notes = [*tips.notes, *([odd.words] if odd else [])]
    said = check_shape(trace, best, groove, numbers)
    known = [(fit, spread_of(fit)) for fit in fits]
    scaled = [
        as_read(*part, groove) if left else on_stated_scale(*part, groove, fitted)
        for part, left in zip(known, left_as_read(fits), strict=True)
    ]
    hidden = [hidden_slope(*part, tips.cones, told=not tips.notes) for part in known]
    curvature = joined([
        curvature_interval(*part, other, groove, correct=correct)
        for part, other in zip(known, scaled, strict=True)
    ])  # fmt: skip
    if not curvature.low > 0:
        raise InputError(
            f"{trace.name}: z_um: C = {curvature.value:.3g} [{curvature.low:.3g}, "
            f"{curvature.high:.3g}] /mm: expected grooves of pitch {groove.pitch / um:g} µm that "
            "can be told from a flat surface"
        )
    right = [(one.fit, one.spread) for one in scaled]
    fill = joined([
        fill_interval(*part, share)
        for part, share in zip([*right, *known], [*hidden, *hidden], strict=True)
    ])  # fmt: skip
    scale_said, heights_off = _scale_notes(trace, best, known[0][1], scaled[0], groove, correct)
    notes += said + scale_said
    late = known[0][1].response.words
    notes += [*([HIDDEN_WORDS] if any(hidden) else []), *([late] if late else [])]
    model, value = best.model, best.value
    tilt, parabola_rms = _levels(best)
    scale = groove.pitch / float(value[PITCH])
    return StylusFit(
        curvature=curvature,
        fitted_curvature=Interval(
            *(
                float(groove.fitted_curvature(c, profile))
                for c in (curvature.value, curvature.low, curvature.high)
            )
        ),
        fill_fraction=fill,
        residual_rms=best.rms,
        fitted_residual_rms=parabola_rms,
        tilt=tilt,
        centre=float(value[0]) + middle,
        position=model.local(value) * scale,
        height=model.levelled(value),
        surface=model.surface(value, traced=False),
        tip=model.tip,
        pitch=float(value[PITCH]),
        depth=model.groove_of(value).depth,
        grooves=widths,
        meniscus=meniscus_shape(*known[0]) if profile == "filled" else None,
        notes=tuple(notes),
        heights_off=heights_off,
    )


def _scale_notes(
    trace: StylusTrace, fit: Fitted, spread: Spread, scaled: Scaled, groove: Groove, correct: bool
) -> tuple[list[str], str]:
    """Return what pitch and walls' slope say of the scale; refuse what no film is off by.

    With it how far the walls' slope is off, empty where it is not.
    """
    pitch, slope = fit.value[PITCH] / groove.pitch - 1, spread.likely_slope / groove.wall_slope - 1
    edges = [edge / groove.wall_slope - 1 for edge in spread.slope]
    wider = [slope + 1.5 * (edge - slope) for edge in edges]
    hidden = slope_hidden(spread, groove)
    found = (
        ("pitch", pitch, abs(pitch) > 1.5 * spread.log_pitch, abs(pitch) - spread.log_pitch,
         f"positions read {{:+.1%}} against the pitch of {groove.pitch / um:g} µm"),
        ("depth", slope, (wider[0] > 0 or wider[1] < 0) and not hidden, max(edges[0], -edges[1]),
         f"the walls are {{:+.1%}} off the slope of depth {groove.depth / um:g} µm"),
    )  # fmt: skip
    notes, heights_off = [], ""
    for name, off, told, least, text in found:
        words = text.format(off)
        if least > REFUSED and not correct:
            raise InputError(
                f"{trace.name}: {words}: expected within {REFUSED:.0%}: --{name}-um of the film, "
                "or --correct where the instrument's scale is off"
            )
        if abs(off) <= NAMED or not told:
            continue
        heights_off = words if name == "depth" else heights_off
        if not correct:
            notes.append(
                f"{words}: the film's {name} or the instrument's scale: the interval holds both "
                "(--correct takes it as the scale)"
            )
        elif name == "pitch":
            notes.append(f"{words}: put right as the instrument's scale")
        else:
            notes.append(
                f"{words}: heights times {1 / scaled.heights[1]:.3f} put right as the instrument's "
                "scale"
            )
    if hidden:
        low, _, high = (part - 1 for part in scaled.heights)
        low, high = (low, high) if correct else (min(low, edges[0]), max(high, edges[1]))
        notes.append(
            f"resin hides the walls: depth {groove.depth / um:g} µm and heights may be "
            f"{low:+.1%} … {high:+.1%} off each other: the interval holds that"
        )
    return notes, heights_off


def _levels(fit: Fitted) -> tuple[float, float]:
    """Return the base line's slope, and what the least-squares parabola leaves of the surface."""
    model, value = fit.model, fit.value
    left = model.z - model.surface(value)
    line = model.base @ (model.base.T @ left)
    tilt = float(np.polyfit(model.x, line, 1)[0])
    surface = model.levelled(value) - model.surface(value) + model.surface(value, traced=False)
    square = model.local(value) ** 2
    design = np.column_stack([np.ones_like(square), square])
    off = surface - design @ np.linalg.lstsq(design, surface, rcond=None)[0]
    return tilt, float(np.sqrt(np.mean(off**2)))
