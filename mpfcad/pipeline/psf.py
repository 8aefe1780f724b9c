"""Point spread functions of LEDs traced, and what the board's zones do."""

from typing import Any

from mpfcad.measure import Lit, TraceRun


def has_zones(lit: Lit) -> bool:
    """Return whether LEDs light a stack in zones that are dimmed by themselves."""
    return getattr(lit.stack.source, "zones", None) is not None


def describe_psf(lit: Lit, run: TraceRun, error_goal: float) -> dict[str, Any]:
    """Return the point spread functions of the LEDs of a cell, and what zones do, as traced."""
    from mpfcad.measure import block_figures, led_spread
    from mpfcad.record import describe_spread

    spread = led_spread(lit, run, error_goal)
    return describe_spread(spread, block_figures(spread, lit.stack.source, run.seed))
