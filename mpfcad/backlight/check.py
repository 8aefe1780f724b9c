"""What the layers and numbers of a stack must be together."""

from mpfcad.backlight.array_mesh import made_mesh
from mpfcad.backlight.layer.plane import matrix_of
from mpfcad.backlight.layer.stated import MADE_KINDS, POLARISING, Layer
from mpfcad.backlight.quantity import FILM_LAYERS, FILM_RANGES
from mpfcad.backlight.source import LedSpec
from mpfcad.backlight.stack import Stack
from mpfcad.errors import InputError
from mpfcad.optics.stokes.mueller import refuse_active

#: What one value of a sheet needs beside it.
_NEEDS = {"axis_deg": "sigma_across", "wide_sigma": "wide_share", "wide_share": "wide_sigma"}


def check_layers(where: str, stack: Stack) -> None:
    """Raise unless the job's film has one place, and a bonded film lies on a plate.

    Raises
    ------
    InputError
        naming the layer.
    """
    layers = stack.layers
    slots = [layer for layer in layers if stack.is_slot(layer)]
    # A table may stand in the film's place; over LEDs a stack may have no film of the job's.
    may_lack = stack.table_layers or stack.spec.kind == LedSpec.kind
    if len(slots) != 1 and (slots or not may_lack):
        raise InputError(
            f"{where}: layers: {len(slots)} films for the job's film: expected exactly one; more "
            "films have a kind and a file"
        )
    _check_film_layers(where, stack)
    _check_lobes(where, stack)
    _check_light(where, stack)
    if "bonded_film" in layers:
        at = layers.index("bonded_film")
        if at == 0 or stack.kind_of(layers[at - 1]) != "plate":
            raise InputError(f"{where}: layers: bonded_film: expected a plate directly below it")


def check_made(where: str, stack: Stack) -> None:
    """Raise unless the values of each film that is made of them make one.

    Raises
    ------
    InputError
        naming the layer and the value.
    """

    def check(layer: Layer) -> None:
        words = f"{where}: layers: {layer.name}"
        made_mesh(layer.kind, words, lambda key: stack[f"{layer.name}.{key}"])

    for layer in stack.own.values():
        if layer.kind in MADE_KINDS:
            check(layer)


def _check_lobes(where: str, stack: Stack) -> None:
    """Raise unless an axis has two widths, and a wide lobe both its width and its share."""
    for name, layer in stack.own.items():
        for value, needs in _NEEDS.items() if layer.kind == "sheet" else ():
            if f"{name}.{value}" in stack.quantity and f"{name}.{needs}" not in stack.quantity:
                raise InputError(
                    f"{where}: layers: {name}: {needs}: missing: expected with {value}"
                )


def _check_light(where: str, stack: Stack) -> None:
    """Raise unless light is polarised where a layer acts on it, and each such layer is passive."""
    _check_converters(where, stack)
    _check_base(where, stack)
    given = [key for key in stack.quantity if key.endswith("depolarisation")]
    if given and not stack.polarised:
        raise InputError(f"{where}: value.{given[0]}: needs light.polarised = true")
    for name, layer in stack.own.items():
        if layer.kind not in POLARISING:
            continue
        at = f"{where}: layers: {name}"
        if not stack.polarised:
            raise InputError(f"{at}: {layer.kind}: needs light.polarised = true")
        if layer.kind == "retarder":
            given = [k for k in ("nm", "waves") if f"{name}.retardation_{k}" in stack.quantity]
            if len(given) != 1:
                said = "both retardation_nm and retardation_waves" if given else "no retardation"
                raise InputError(f"{at}: {said}: expected one of the two")
        if layer.kind == "mueller":
            refuse_active(at, matrix_of(stack, name))
        for way in ("along", "across"):
            parts = [f"{name}.{part}_{way}" for part in ("transmission", "reflection")]
            shares = [stack[part] for part in parts if part in stack.quantity]
            if sum(shares) > 1.0 + 1e-12:
                raise InputError(
                    f"{at}: transmission_{way} {shares[0]:g} and reflection_{way} {shares[1]:g}: "
                    "expected at most 1 together, as a passive layer has"
                )


def _check_base(where: str, stack: Stack) -> None:
    """Raise unless a birefringent base is one, and light is polarised."""
    retardation, axis = "film_base_retardation_nm", "film_base_axis_deg"
    given = [key for key in (retardation, axis) if key in stack.quantity]
    if given and not stack.polarised:
        raise InputError(f"{where}: value.{given[0]}: needs light.polarised = true")
    for need in (retardation, "film_base_index"):
        if given and need not in stack.quantity:
            raise InputError(f"{where}: value.{need}: missing: expected with {given[0]}")


def _check_converters(where: str, stack: Stack) -> None:
    """Raise unless each layer that converts light says once how much it takes, and how thick."""
    for name in stack.converters:
        at = f"{where}: layers: {name}"
        given = [key for key in ("absorptance", "absorption_per_mm", "thickness_um")
                 if f"{name}.{key}" in stack.quantity]  # fmt: skip
        is_film = f"{name}.scattering_per_mm" in stack.quantity
        ways = [["absorptance"], ["absorption_per_mm", "thickness_um"]]
        if is_film:
            ways[0].append("thickness_um")
        if given not in ways:
            said = ", ".join(given) or "no absorption"
            first = "absorptance with thickness_um" if is_film else "absorptance"
            raise InputError(
                f"{at}: {said}: expected {first}, or absorption_per_mm with thickness_um"
            )
        if f"{name}.asymmetry" in stack.quantity and not is_film:
            raise InputError(f"{at}: scattering_per_mm: missing: expected with asymmetry")


def _check_film_layers(where: str, stack: Stack) -> None:
    """Raise unless each layer of the film has index and thickness, and the film a place for it."""
    given = [key for key in FILM_RANGES if key in stack.quantity]
    for layer in FILM_LAYERS:
        stated = [key for key in given if key.startswith(layer)]
        for need in ("index", "thickness_um"):
            if stated and f"{layer}_{need}" not in stated:
                raise InputError(
                    f"{where}: value.{layer}_{need}: missing: expected with {stated[0]}"
                )
    base, primer = (f"{layer}_thickness_um" for layer in FILM_LAYERS)
    if primer in given and base not in given:
        raise InputError(f"{where}: value.{base}: missing: expected under the film's primer")
    own = stack.own.get(stack.slot) if stack.slot else None
    if given and not stack.has_slot:
        raise InputError(f"{where}: value.{given[0]}: the stack has no place of the job's film")
    for key in ("absorption_per_mm", "roughness"):
        if own is not None and f"film_{key}" in given:
            raise InputError(
                f"{where}: value.film_{key}: the film's layer states its own: expected "
                f"{own.name}.{key}"
            )
    if own is not None and own.flipped and any(k.startswith(FILM_LAYERS) for k in given):
        raise InputError(
            f"{where}: layers: {own.name}: flipped: a film with base or primer: expected upright"
        )
