"""Whether the confidence that a job asks for can be found, before anything is traced."""

from textwrap import shorten

from mpfcad.backlight.width import width_of
from mpfcad.errors import InputError
from mpfcad.pipeline.confidence.cell_variant import CELL_INPUTS
from mpfcad.pipeline.confidence.find import refuse_confidence
from mpfcad.pipeline.confidence.variant import FILM_INPUTS
from mpfcad.pipeline.plan.plan import Plan

#: Characters of a list of names in a message.
_SHOWN = 150
#: Largest standard uncertainty of the registration, as a share of the LEDs' cell: a curve follows a
#: shift in second order.
_MOST_SHIFT = 1 / 8


def refuse_unlikely(where: str, plan: Plan) -> None:
    """Raise where the confidence that a job asks for is not found, or is asked with what is wrong.

    Raises
    ------
    InputError
        that begins with `where`, for a stack without confidence, a covariance of what is no input
        of any job, or a registration that is not small beside the LEDs' cell.
    """
    _refuse_unknown_inputs(where, plan)
    if not plan.job.wants_confidence:
        return
    try:
        refuse_confidence(plan.stack)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    size = plan.job.confidence_table.registration_mm
    if plan.stack.period.along > 0 and size > _MOST_SHIFT * min(plan.stack.source.cell):
        across, along = plan.stack.source.cell
        raise InputError(
            f"{where}: confidence.registration_mm: {size:g}: expected at most an eighth of the "
            f"LEDs' cell of {across:g} × {along:g} mm"
        )


def _refuse_unknown_inputs(where: str, plan: Plan) -> None:
    """Raise where a covariance names what is no input."""
    stack = plan.stack
    films = CELL_INPUTS if stack.period.along > 0 else FILM_INPUTS
    known = [name for name in stack.quantity if width_of(stack, name).sigma > 0]
    unknown = sorted(set(plan.job.confidence_table.sigmas()) - {*known, *films})
    if unknown:
        raise InputError(
            f"{where}: confidence.covariance: {unknown[0]}: expected inputs that are not exact: "
            f"{shorten(', '.join([*films, *known]), _SHOWN, placeholder=' …')}"
        )
