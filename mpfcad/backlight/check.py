"""What the layers and numbers of a stack must be together."""

from itertools import pairwise

from mpfcad.backlight.quantity import lamp_of
from mpfcad.backlight.stack import Stack
from mpfcad.errors import InputError


def check_layers(where: str, stack: Stack) -> None:
    """Raise unless the job's film has one place, and a bonded film lies on a plate.

    Raises
    ------
    InputError
        naming the layer.
    """
    layers = stack.layers
    slots = [layer for layer in layers if stack.is_slot(layer)]
    # A table may stand in the film's place.
    if len(slots) != 1 and (slots or not stack.table_layers):
        raise InputError(
            f"{where}: layers: {len(slots)} films for the job's film: must be exactly one; more "
            "films have a kind and a file"
        )
    if "bonded_film" in layers:
        at = layers.index("bonded_film")
        if at == 0 or stack.kind_of(layers[at - 1]) != "plate":
            raise InputError(f"{where}: layers: bonded_film: must lie directly on a plate")


def check_fits(where: str, stack: Stack) -> None:
    """Raise unless the lamps fit under the plate, beside each other and on the panel.

    Raises
    ------
    InputError
        naming the value and its limit.
    """
    radius, height = stack["lamp_radius_mm"], stack["lamp_height_mm"]
    if height < radius:
        raise InputError(
            f"{where}: lamp_height_mm: {height:g}: must be at least the radius {radius:g}"
        )
    if stack.thickness <= height + radius:
        raise InputError(
            f"{where}: thickness_mm: {stack.thickness:g}: must be above the lamps' tops at "
            f"{height + radius:g} mm"
        )
    if stack.lamp_pitch <= 2 * radius:
        raise InputError(
            f"{where}: lamp_pitch_mm: {stack.lamp_pitch:g}: must be above the lamps' diameter "
            f"{2 * radius:g}"
        )
    if stack.lamp_position(0) < 0:
        raise InputError(
            f"{where}: lamp_count: {stack.lamp_count}: at pitch {stack.lamp_pitch:g} mm the row is "
            f"wider than the panel's {stack.panel_width:g} mm"
        )
    _check_lamps(where, stack)


def _check_lamps(where: str, stack: Stack) -> None:
    """Raise unless single lamps exist, stay on the panel and apart from each other."""
    for key, quantity in stack.quantity.items():
        number = lamp_of(key)
        if number is None:
            continue
        if stack.extent != "panel":
            raise InputError(
                f"{where}: {key}: {quantity.value:g}: lamps differ on a whole panel only: "
                'extent must be "panel"'
            )
        if number > stack.lamp_count:
            raise InputError(f"{where}: {key}: lamp {number}: must be at most {stack.lamp_count}")
    if stack.extent != "panel":
        return
    radius = stack["lamp_radius_mm"]
    position = sorted(stack.shifted_position(i) for i in range(stack.lamp_count))
    edges = (position[0] >= radius, position[-1] <= stack.panel_width - radius)
    gaps = [b - a for a, b in pairwise(position)]
    if not all(edges) or any(gap <= 2 * radius for gap in gaps):
        raise InputError(
            f"{where}: lamp_N_shift_mm: lamps at {', '.join(f'{p:g}' for p in position)} mm: must "
            f"stay {2 * radius:g} mm apart and within the panel's {stack.panel_width:g} mm"
        )
    if not any(stack.lamp_factor(i) for i in range(stack.lamp_count)):
        raise InputError(f"{where}: lamp_N_luminance_factor: all 0: one lamp must shine")
