"""How far resin levels along a groove, from its viscosity, surface tension, contact angle and time.

A groove of 90° that holds resin to the height h is a channel of area A = h² whose surface meets the
walls at the contact angle θ. Its radius is R = h / sin(45° - θ), so the pressure is -γ/R: it draws
resin along as long as θ < 45° (Concus and Finn, 1969; Romero and Yost, J. Fluid Mech. 322, 1996).
With the flow Q = -Γ h⁴/μ · dp/dz of half a square duct (its diagonal is a free surface by symmetry:
Γ = 4 · 0.03514/2 = 0.0703; White, Viscous Fluid Flow) and dA/dt = -dQ/dz the fill obeys

    dh/dt = D d²h/dz²,   D = Γ sin(45° - θ) γ h / (2 μ)   for small differences,

so after the time t a print is averaged with a Gauss curve of variance 2 D t. The surface is taken
as flat in Γ; a hollow one has a little less area, and flows a little less.
"""

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.units import deg

#: Γ of half a square duct of side √2 h with a free diagonal: Q = 0.0351443 a⁴ G/μ of the whole.
DUCT = 4 * 0.0351443 / 2
#: Contact angle from which resin does not run along a groove of 90° [rad].
STANDING = 45 * deg
#: Cells over a levelling length of the flow that is solved, and its time step over the longest.
POINTS, STABLE = 16, 0.4
FULL_WIDTH = float(2 * (2 * np.log(2)) ** 0.5)


def levelling_length(
    fill_fraction: float,
    depth: float,
    *,
    viscosity: float,
    surface_tension: float,
    contact_angle: float,
    time: float,
) -> float:
    """Return the full width at half maximum [mm] of the Gauss curve that levelling averages with.

    Parameters
    ----------
    fill_fraction
        of the groove, wet; the least filled groove levels least
    depth
        of the groove [mm]
    viscosity, surface_tension
        [Pa·s], [N/m]
    contact_angle
        of resin and wall [rad]
    time
        from print to UV [s]

    Raises
    ------
    InputError
        for a contact angle of 45° or more: the resin stays where it was printed.

    Examples
    --------
    >>> round(levelling_length(0.12, 0.025, viscosity=0.4, surface_tension=0.03,
    ...                        contact_angle=0.17, time=10.0), 2)
    1.2
    """
    if contact_angle >= STANDING:
        raise InputError(
            f"contact_angle_deg: {contact_angle / deg:g}: expected below 45: from there on resin "
            f"does not run along a groove of 90° (Concus-Finn), and nothing levels"
        )
    height = fill_fraction**0.5 * depth  # A = fill · depth² in a groove of 90°
    drive = np.sin(STANDING - contact_angle) * surface_tension / viscosity  # m/s
    diffusion = DUCT * drive * 1000 * height / 2  # mm²/s
    return FULL_WIDTH * float(2 * diffusion * time) ** 0.5


def levelled_fill(
    fill: NDArray[np.float64],
    length: float,
    parts: int,
    levelling: float,
    at: float,
    shift: float = 0.0,
) -> NDArray[np.float64]:
    """Return the mean fill of each part of a piece once the resin has run along, (n, m·parts).

    The whole flow, not that of small differences: with h² = A, the channel's area, the equations
    above are dA/dt = (2/3) D₁ d²(A^3/2)/dz² in units of the area whose D is D₁. So resin that ends
    at bare groove has a front that stops, where a Gauss curve would run on (a porous-medium
    equation; Barenblatt 1952). It is solved by finite volumes that keep the resin, explicitly.

    Parameters
    ----------
    fill
        (n, m), of m pieces of n grooves as printed, that repeat along
    length
        of a piece [mm]
    parts
        of a piece
    levelling
        full width at half maximum [mm] of the Gauss curve of small differences from the fill `at`
    shift
        of the print along [mm]

    Examples
    --------
    >>> levelled_fill(np.array([[0.1, 0.0]]), 4.0, 1, 1.0, 0.1).round(4)
    array([[0.0951, 0.0049]])
    """
    sigma = levelling / FULL_WIDTH
    fine = max(1, int(np.ceil(POINTS * length / parts / levelling)))
    step = length / parts / fine
    rows, number = np.unique(fill, axis=0, return_inverse=True)
    area = _laid(rows, length, parts * fine, shift) / at
    fastest = float(np.sqrt(area.max(initial=0.0)))
    count = int(np.ceil(fastest * (sigma / step) ** 2 / 2 / STABLE))
    rate = (2 / 3) * (sigma / step) ** 2 / 2 / max(count, 1)
    for _ in range(count):
        flow = area * np.sqrt(area)
        flow = rate * (flow - np.roll(flow, 1, axis=1))  # out of a cell to that before it
        area = area - flow + np.roll(flow, -1, axis=1)
    means = area.reshape(len(rows), -1, fine).mean(axis=2) * at
    return np.asarray(means[number.ravel()], np.float64)


def modulation_left(length: float, levelling: float) -> float:
    """Return what levelling leaves of printed and bare pieces in turn: (max - min)/(max + min).

    `length` of a piece and `levelling` length in mm.

    Examples
    --------
    >>> [round(modulation_left(x, 1.0), 2) for x in (0.5, 1.0, 4.0)]
    [0.1, 0.65, 1.0]
    """
    parts = max(2, int(np.ceil(POINTS * length / levelling)))
    found = levelled_fill(np.array([[1.0, 0.0]]), length, parts, levelling, 1.0)
    low, high = float(found.min()), float(found.max())
    return (high - low) / (high + low)


def _laid(
    rows: NDArray[np.float64], length: float, cells: int, shift: float
) -> NDArray[np.float64]:
    """Return the mean fill of each cell of a piece as printed, so far along [mm]."""
    count = rows.shape[1]
    total = np.concatenate([np.zeros((len(rows), 1)), np.cumsum(rows, axis=1)], axis=1)
    place = np.arange(count * cells + 1) / cells - shift / length
    turn, piece = np.divmod(np.floor(place).astype(np.int64), count)
    before = total[:, piece] + turn * total[:, -1:] + (place - np.floor(place)) * rows[:, piece]
    return np.asarray(np.diff(before, axis=1) * cells, np.float64)
