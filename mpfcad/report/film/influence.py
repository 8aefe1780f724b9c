"""What each assumed input would change, in words; and by how much, where that was traced."""

from typing import Any

from mpfcad.backlight import Stack
from mpfcad.backlight.width import width_of
from mpfcad.report.page.number import value_words

Record = dict[str, Any]
_SPREAD = "how far light spreads: the contrast, and a little luminance"
_LOSS = "how much light comes back: luminance, and a little contrast"
_BEND = "how light is bent: angular width, luminance, contrast"
_CUP = "how cups gather the light of the LEDs: the contrast, and a little luminance"
_START = "where light starts: the contrast"
_ARTWORK = "how the artwork is drawn and handed over; no figure of the light"
_HEADER = "what the files say of themselves; no figure"
_RULE = "what the screen is refused or judged by; no figure of the light"
#: End of an input's name -> what hangs on it; the first that fits.
_INFLUENCE = (
    ("luminance_cd_m2", "every luminance in proportion; no contrast"),
    ("flux_lm", "every luminance in proportion; no contrast"),
    ("panel_width_mm", "size of mask and film, number of grooves"),
    ("panel_length_mm", "size of mask and film"),
    ("lamp_count", "luminance; on a finite panel the contrast"),
    ("lamp_pitch_mm", "distance of the lamps: the contrast, and the map's own scale"),
    ("pitch_across_mm", "distance of the LEDs: the contrast, and the map's own scale"),
    ("pitch_along_mm", "distance of the LEDs: the contrast, and the map's own scale"),
    ("cup_height_mm", _CUP),
    ("cup_radius_mm", _CUP),
    ("rim_radius_mm", _CUP),
    ("cup_specular_fraction", _CUP),
    ("height_mm", _START),
    ("hole_radius_mm", _LOSS),
    ("radius_mm", "size of the lamps: contrast, and the light that they absorb"),
    ("plate_thickness_mm", _SPREAD),
    ("base_um", "distance from the prisms to the plate; little of either"),
    ("stack.thickness_mm", "room in which light spreads: more than any other input, the contrast"),
    ("reflectance", _LOSS),
    ("absorption_per_mm", _LOSS),
    ("transmission", _LOSS),
    ("specular_fraction", "how the reflector spreads light: the contrast"),
    ("scattering_per_mm", _SPREAD),
    ("asymmetry", _SPREAD),
    ("roughness", _SPREAD),
    ("sigma", _SPREAD),
    ("particle_radius_um", _SPREAD),
    ("particle_density_per_mm3", _SPREAD),
    ("index", _BEND),
    ("light_wavelength_nm", _BEND),
    ("meter_acceptance_deg", "what the meter takes in: a wider cone evens out the contrast"),
    ("meter_spot_mm", "what the meter takes in: a wider spot evens out the contrast"),
    ("mask.pattern", "ripple after levelling, and which meshes hold the screen"),
    ("mask.period_um", "ripple after levelling, and the smallest aperture"),
    ("mask.min_aperture_um", _RULE),
    ("mask.min_web_um", _RULE),
    ("mask.levelling_length_mm", "ripple after levelling; measure it on a printed coupon"),
    ("mask.viewing_distance_mm", "the eye's threshold alone; no gate"),
    ("mask.registration_um", "the gate of the registration"),
    ("mask.mesh", "resin that is laid down, and so the curvature; smallest aperture and web"),
    ("cad.length_mm", "length of the piece in the CAD files; the trace repeats it"),
    ("cad.extent", "how much of the panel the CAD files hold; the trace repeats it"),
    ("cad.angle_tolerance_deg", "facets of film.stl (How it settles)"),
    ("cad.bodies", "solids in film.step; no figure"),
    ("cad.stl", "how film.stl is cut; no figure"),
)
_ORDER = ("stack", "map", "film", "process", "mask", "gates", "cad")
_TABLES = (("mask.", _ARTWORK), ("cad.", _HEADER), ("gates.", "what is accepted; no figure"),
           ("stack.", "contrast and luminance"), ("process.", "resin, and so the curvature"),
           ("film.", "shape of the prisms: contrast and luminance"))  # fmt: skip


def influence_of(name: str) -> str:
    """Return what an input would change, in words.

    >>> influence_of("stack.lamp_luminance_cd_m2")
    'every luminance in proportion; no contrast'
    """
    for end, words in _INFLUENCE:
        if name.endswith(end):
            return words
    return next((words for start, words in _TABLES if name.startswith(start)), "not known")


def assumed_rows(record: Record, stack: Stack) -> list[list[str]]:
    """Return name, what it changes, value, width and share of the curve's variance, of each."""
    found = {one["name"]: one for one in (record.get("confidence") or {"inputs": []})["inputs"]}
    assumed = [entry for entry in record["inputs"] if entry["tag"] == "assumed"]
    rows = []
    # What the light hangs on first, and last what only the files' form does.
    for entry in sorted(assumed, key=lambda one: _ORDER.index(one["name"].partition(".")[0])):
        name = entry["name"].removeprefix("stack.")
        traced = found.get(name)
        share = "" if traced is None else f"{traced['share_of_variance']:.1%}"
        rows.append(
            [entry["name"], influence_of(entry["name"]), value_words(entry["value"]),
             _width(stack, name, traced), share]
        )  # fmt: skip
    return rows


def _width(stack: Stack, name: str, traced: Record | None) -> str:
    """Return how well an input of the backlight is known."""
    if traced is not None:
        return f"± {traced['sigma']:.2g}"
    if name not in stack.quantity:
        return ""
    size = width_of(stack, name).sigma
    return f"± {size:.2g}" if size else "exact"
