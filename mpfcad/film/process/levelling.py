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

from mpfcad.errors import InputError
from mpfcad.units import deg

#: Γ of half a square duct of side √2 h with a free diagonal: Q = 0.0351443 a⁴ G/μ of the whole.
DUCT = 4 * 0.0351443 / 2
#: Contact angle from which resin does not run along a groove of 90° [rad].
STANDING = 45 * deg
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
