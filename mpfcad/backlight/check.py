"""What the layers and numbers of a stack must be together."""

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
