"""Numbers of a stack that follow from others: defaults, and what particles scatter."""

from mpfcad.backlight.layer.stated import LEFT_OUT, OWN_VALUES
from mpfcad.backlight.particle import MEDIUM, PARTICLE, build_particles
from mpfcad.backlight.quantity import Quantity, Tag
from mpfcad.backlight.stack import Stack
from mpfcad.errors import InputError

_WAVELENGTH = Quantity(550.0, "assumed", "default: the middle of the visible")
#: Share of the panel's width on each side that is not judged unless a job says so.
_RIM = 0.1


def derive(where: str, stack: Stack) -> Stack:
    """Return the stack with every number that follows from those given.

    Raises
    ------
    InputError
        when a value that is needed is missing.
    """
    quantity = dict(stack.quantity)
    for name, layer in stack.own.items():
        for value, (_, _, default) in OWN_VALUES[layer.kind].items():
            key = f"{name}.{value}"
            if key not in quantity and default != LEFT_OUT:
                quantity[key] = _default(where, key, default, quantity)
    for key, (_, default) in stack.spec.optional.items():
        if key not in quantity:
            quantity[key] = _default(where, key, default, quantity)
    if stack.extent == "panel":
        for key, base in (
            *stack.spec.defaults.items(),
            ("wall_reflectance", "reflector_reflectance"),
            ("wall_specular_fraction", "reflector_specular_fraction"),
        ):
            if key not in quantity:
                quantity[key] = Quantity(quantity[base].value, "assumed", f"default: {base}")
    if stack.extent == "panel" and "rim_mm" in stack.spec.panel_ranges and "rim_mm" not in quantity:
        quantity["rim_mm"] = _default_rim(stack.with_values(quantity))
    for body in MEDIUM:
        quantity.update(_scattering(where, body, quantity))
    return stack.with_values(quantity)


def _default(
    where: str, key: str, default: str | float | None, quantity: dict[str, Quantity]
) -> Quantity:
    if default is None:
        raise InputError(f"{where}: layers: {key}: missing: expected a value")
    if isinstance(default, str):
        base = quantity[default]
        return Quantity(base.value, base.tag, f"as {default}: {base.source}")
    return Quantity(default, "assumed", "default")


def _default_rim(stack: Stack) -> Quantity:
    """Return the rim [mm] that is not judged: as far in as a screen's outer meter points stand.

    These lie a tenth of the width from the edge (VESA, "Flat panel display measurements standard",
    2.0, 2001, sampled uniformity). The middle's pitch is judged in any case.
    """
    left, pitch = stack.origin[0], stack.period.across
    most = max(0.0, min(left, stack.panel_width - left - pitch))
    tenth = round(_RIM * stack.panel_width, 6)
    if tenth <= most:
        return Quantity(tenth, "assumed", "default: a tenth of the panel's width")
    return Quantity(most, "assumed", "default: all but the middle's lamp pitch")


def _scattering(where: str, body: str, quantity: dict[str, Quantity]) -> dict[str, Quantity]:
    """Return coefficient and asymmetry of the particles in a plate or resin, where there are."""
    keys = [f"{body}_{name}" for name in PARTICLE]
    there = [key for key in keys if key in quantity]
    if not there:
        if f"{body}_scattering_per_mm" in quantity and f"{body}_asymmetry" not in quantity:
            return {f"{body}_asymmetry": Quantity(0.0, "assumed", "default: isotropic")}
        return {}
    missing = [key for key in keys if key not in quantity]
    if missing:
        raise InputError(f"{where}: {missing[0]}: missing: expected all of {', '.join(keys)}")
    wavelength = quantity.get("light_wavelength_nm", _WAVELENGTH)
    particles = build_particles({**quantity, "light_wavelength_nm": wavelength}, body)
    assert particles is not None  # none is missing
    tags = {quantity[key].tag for key in keys}
    tag: Tag = "assumed" if "assumed" in tags else "sourced" if "sourced" in tags else "given"
    medium = f"{body}_index" if f"{body}_index" in quantity else MEDIUM[body]
    source = f"Mie's theory, from {', '.join(keys)}, {medium}, light_wavelength_nm"
    return {
        "light_wavelength_nm": wavelength,
        f"{body}_scattering_per_mm": Quantity(particles.scattering, tag, source),
        f"{body}_asymmetry": Quantity(particles.asymmetry, tag, source),
    }
