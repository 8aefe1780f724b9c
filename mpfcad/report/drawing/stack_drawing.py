"""The stack across the lamps, from the reflector up to the viewer, drawn from its values."""

from itertools import pairwise

from mpfcad.backlight import Stack
from mpfcad.backlight.layer.stated import CONVERTER, POLARISING
from mpfcad.backlight.quantity import FILM_LAYERS
from mpfcad.report.drawing import svg

#: Sizes in the drawing: left edge, width, height of the cavity, of a layer and between layers.
LEFT, WIDTH, CAVITY, LAYER, GAP = 20.0, 470.0, 190.0, 26.0, 12.0
LAMPS = 3
STYLE = {
    "clear_plate": 'fill="#e3eef7" stroke="#7a94ab"',
    "diffusing_plate": 'fill="#d5d9de" stroke="#7d858e"',
    "bottom_sheet": 'fill="#efe6d8" stroke="#a08f70"',
    "top_sheet": 'fill="#efe6d8" stroke="#a08f70"',
}
#: What a plate or sheet of one's own is drawn like.
OTHER = {
    "plate": "clear_plate", "sheet": "bottom_sheet", "bsdf": "bottom_sheet",
    "polariser": "diffusing_plate", "reflective_polariser": "clear_plate",
    "retarder": "clear_plate", "mueller": "clear_plate", "converter": "bottom_sheet",
}  # fmt: skip
FILM = 'fill="#c9dcee" stroke="#5d7f9f"'
RESIN = 'fill="#f2c572" stroke="none"'
LIGHT = 'fill="#ffe9a8" stroke="#b58a1b"'
SOFT = 'font-size="12" fill="#5a6570"'


def draw_stack(stack: Stack) -> str:
    """Return the SVG of a stack; heights of layers are not to scale, the cavity is."""
    height = 50 + CAVITY + len(stack.layers) * (LAYER + GAP)
    floor = height - 26
    parts = _draw_cavity(stack, floor)
    top = floor - CAVITY
    for i, layer in enumerate(stack.layers):
        bonded = layer == "bonded_film"
        top -= LAYER + (GAP if i and not bonded else 0)
        parts += _draw(stack, layer, top)
        parts += _label(top + LAYER / 2, stack.title_of(layer), _note(stack, layer))
    parts.append(svg.text(LEFT, 16, "↑ viewer", SOFT))
    return svg.picture(860, height, f"Stack {stack.name}", parts)


def _draw_cavity(stack: Stack, floor: float) -> list[str]:
    """Return reflector, lamps and the dimension of the cavity above `floor`."""
    scale = CAVITY / stack.thickness
    across = WIDTH / LAMPS
    lit = stack.source.emitters()
    radius = max(lit.height / 2 * scale, 3)
    y = floor - lit.centre * scale
    parts = [svg.rectangle(LEFT, floor, WIDTH, 8, 'fill="#fff" stroke="#444"')]
    for i in range(LAMPS):
        x = LEFT + (i + 0.5) * across
        if lit.is_round:
            parts.append(svg.circle(x, y, radius, LIGHT))
        else:
            wide = max(lit.width * scale, 6)
            parts.append(svg.rectangle(x - wide / 2, y - radius, wide, 2 * radius, LIGHT))
    first, second, level = LEFT + across / 2, LEFT + 1.5 * across, y - radius - 12
    parts += _dimension((first, level), (second, level), f"{lit.spacing:g} mm")
    right = LEFT + WIDTH - 14
    parts += _dimension((right, floor), (right, floor - CAVITY), f"{stack.thickness:g} mm")
    specular = stack["reflector_specular_fraction"] * 100
    note = f"reflectance {stack['reflector_reflectance']:g}, {specular:g} % of it specular"
    if "reflector" in stack.tables:
        note = f"by its BRDF table {stack.tables['reflector'].name}"
    parts += _label(floor + 4, "reflector", note)
    return parts + _label(y - 8, lit.name, lit.note)


def _draw(stack: Stack, layer: str, top: float) -> list[str]:
    """Return the picture of a layer from `top` down."""
    if stack.kind_of(layer) != "film":
        style = STYLE.get(layer, STYLE[OTHER[stack.kind_of(layer)]])
        return [svg.rectangle(LEFT, top, WIDTH, LAYER, style)]
    own = stack.own.get(layer)
    if own is not None and abs(stack[f"{layer}.rotation_deg"]) % 180 > 1:
        # Seen along its grooves a crossed film is a plain band.
        return [svg.rectangle(LEFT, top, WIDTH, LAYER, FILM)]
    return _draw_film(top, filled=stack.is_slot(layer), down=own is not None and own.flipped)


def _draw_film(top: float, filled: bool, down: bool) -> list[str]:
    """Return a film with prisms, whose grooves hold some resin if `filled`."""
    parts = _upright_film(top, filled)
    if not down:
        return parts
    return [f'<g transform="matrix(1 0 0 -1 0 {2 * top + LAYER:g})">', *parts, "</g>"]


def _upright_film(top: float, filled: bool) -> list[str]:
    count, depth = 24, 14.0
    pitch = WIDTH / count
    tips = [(LEFT + i * pitch, top) for i in range(count + 1)]
    walls = [tips[0]]
    resin = []
    for (x, y), tip in pairwise(tips):
        walls += [(x + pitch / 2, y + depth), tip]
        low, level = y + depth, y + depth * 0.62
        half = pitch / 2 * 0.38
        middle = x + pitch / 2
        corners = [(middle - half, level), (middle, low), (middle + half, level)]
        resin.append(svg.polygon(corners, RESIN))
    foot = [(LEFT + WIDTH, top + LAYER), (LEFT, top + LAYER)]
    return [svg.polygon([*walls, *foot], FILM), *(resin if filled else ())]


def _note(stack: Stack, layer: str) -> str:
    """Return a layer's values in words."""
    if layer in stack.own:
        return _own_note(stack, layer)
    if layer.endswith("sheet"):
        sigma, share = stack[f"{layer}_sigma"], stack["sheet_transmission"] * 100
        return f"σ = {sigma:g} of the direction cosines, {share:g} % of the light"
    if layer.endswith("film"):
        return f"n = {stack['film_index']:g}{_materials(stack)}"
    note = f"n = {stack['plate_index']:g}, {stack['plate_thickness_mm']:g} mm"
    if layer == "diffusing_plate":
        note += (
            f", scattering {stack['plate_scattering_per_mm']:.4g} /mm, "
            f"g = {stack['plate_asymmetry']:.4g}"
        )
    return note


def _materials(stack: Stack) -> str:
    """Return the film's other materials in words: its base and primer, and the resin."""
    note = ""
    if stack.resin_differs:
        note += f"; resin n = {stack.get('resin_index', stack.of_film('index')):g}"
    if stack.resin_scatters:
        scattering, g = stack["resin_scattering_per_mm"], stack["resin_asymmetry"]
        note += f"; resin scatters {scattering:.3g} /mm, g = {g:.3g}"
    if stack.of_film("roughness") > 0:
        note += f"; facets of rms slope {stack.of_film('roughness'):g}"
    for layer in FILM_LAYERS:
        if f"{layer}_index" in stack.quantity:
            words = layer.rpartition("_")[2]
            thickness, index = stack[f"{layer}_thickness_um"], stack[f"{layer}_index"]
            note += f"; {words} {thickness:g} µm, n = {index:g}"
    return note


def _own_note(stack: Stack, layer: str) -> str:
    """Return the values of a layer's own in words."""
    kind = stack.own[layer].kind
    if kind == "bsdf":
        return stack.tables[layer].name

    def value(key: str) -> float:
        return stack[f"{layer}.{key}"]

    if kind == "sheet":
        share = value("transmission") * 100
        width = f"σ = {value('sigma'):g}"
        if f"{layer}.sigma_across" in stack.quantity:
            width += f" × {value('sigma_across'):g}"
        if f"{layer}.axis_deg" in stack.quantity:
            width += f" at {value('axis_deg'):g}°"
        if f"{layer}.wide_share" in stack.quantity:
            width += f" and {value('wide_sigma'):g} ({value('wide_share') * 100:g} %)"
        return f"{width} of the direction cosines, {share:g} % of the light"
    if kind in POLARISING:
        return _axis_note(stack, layer)
    note = f"n = {value('index'):g}"
    if kind == CONVERTER:
        emission = stack.bands.emission[layer].title if stack.bands else "light"
        said = f"emits {emission}, {value('yield') * 100:g} % of the photons it takes"
        if f"{layer}.scattering_per_mm" in stack.quantity:
            return f"film, {note}, {value('thickness_um'):g} µm, {said}"
        return said
    if kind == "plate":
        note += f", {value('thickness_mm'):g} mm"
        if value("scattering_per_mm") > 0:
            note += f", scattering {value('scattering_per_mm'):g} /mm, g = {value('asymmetry'):g}"
        return note
    if kind in ("bef", "composite"):
        note += f", prisms {value('pitch_um'):g} × {value('depth_um'):g} µm"
    if kind == "composite":
        note += f", {value('bond_um'):g} µm deep in a cover of {value('cover_um'):g} µm"
        if value("upper_depth_um") > 0:
            note += f" with prisms {value('upper_pitch_um'):g} × {value('upper_depth_um'):g} µm"
    if kind == "lens":
        note += f", lenses {value('pitch_um'):g} µm apart, {value('sag_um'):g} µm high"
    turn = value("rotation_deg")
    note += f", turned {turn:g}°" if turn else ""
    return note + (_materials(stack) if stack.is_slot(layer) else "")


def _axis_note(stack: Stack, layer: str) -> str:
    """Return the values of a polariser or retarder in words."""
    axis = f"axis {stack[f'{layer}.axis_deg']:g}° from the grooves"
    if stack.own[layer].kind == "retarder":
        waves, nm = stack[f"{layer}.retardation_waves"], stack[f"{layer}.retardation_nm"]
        return f"{axis}, {f'{waves:g} waves' if waves else f'{nm:g} nm'}"
    if stack.own[layer].kind == "mueller":
        return f"{axis}, passes {stack[f'{layer}.m00'] * 100:g} % of unpolarised light"
    along, across = (stack[f"{layer}.transmission_{way}"] * 100 for way in ("along", "across"))
    return f"{axis}, passes {along:g} % along it, {across:g} % across"


def _label(y: float, name: str, note: str) -> list[str]:
    x = LEFT + WIDTH + 16
    return [
        svg.text(x, y - 1, name, 'font-size="13" font-weight="600"'),
        svg.text(x, y + 13, note, SOFT),
    ]


def _dimension(start: tuple[float, float], end: tuple[float, float], label: str) -> list[str]:
    """Return a dimension line, horizontal or upward, with its label."""
    style = 'stroke="#5a6570" stroke-width="1"'
    (x1, y1), (x2, y2) = start, end
    parts = [svg.line(x1, y1, x2, y2, style)]
    if y1 == y2:
        parts += [svg.line(x, y1 - 4, x, y1 + 4, style) for x in (x1, x2)]
        parts.append(svg.text((x1 + x2) / 2, y1 - 6, label, SOFT + ' text-anchor="middle"'))
    else:
        parts += [svg.line(x1 - 4, y, x1 + 4, y, style) for y in (y1, y2)]
        parts.append(svg.text(x1 - 8, (y1 + y2) / 2, label, SOFT + ' text-anchor="end"'))
    return parts
