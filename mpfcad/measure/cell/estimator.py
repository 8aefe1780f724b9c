"""The ways in which a cell of LEDs can be traced, and which of them was taken."""

from dataclasses import dataclass
from enum import StrEnum


class Estimator(StrEnum):
    """Which way a cell of LEDs is traced.

    `forward`: from the LEDs, joined with the meter at the topmost sheet. `backward`: from the
    meter, meeting LEDs by chance. `auto`: what a short trace of both finds to need less work.
    """

    auto = "auto"
    forward = "forward"
    backward = "backward"


@dataclass(frozen=True)
class Choice:
    """Which way a cell was traced.

    Attributes
    ----------
    estimator
        `forward` or `backward`
    reason
        in words
    work
        of each estimator that was tried: how many times an element is passed until the harmonics
        have a relative variance of 1 together; none where there was nothing to choose
    """

    estimator: Estimator
    reason: str
    work: tuple[tuple[Estimator, float], ...] = ()
