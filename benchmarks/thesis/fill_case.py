"""Films filled with resin that scatters, beside the same films with a clear resin."""

from dataclasses import dataclass, replace
from pathlib import Path

from mpfcad.backlight import Stack, read_stack
from thesis.film_case import EMPTY, PRINTED, Case, file_hash, film_mesh

#: Share of the groove that is filled, and the curvature [1/mm] that it gives.
FILLS = {0.10: PRINTED, 1 / 3: 40.0, 0.75: 15.0, 1.0: 0.0}
DENSITY_PER_MM3, RADIUS_UM, INDEX = 1e5, 5.0, 1.45
#: Twice the spheres' cross-section, what spheres far larger than the wavelength take out [1/mm].
SCATTERING_PER_MM = 15.7
ASYMMETRY = 0.5
#: What the fill holds, as values of the stack.
RESIN = {
    "filled": {},
    "mie": {
        "resin_particle_radius_um": RADIUS_UM,
        "resin_particle_index": INDEX,
        "resin_particle_density_per_mm3": DENSITY_PER_MM3,
    },
    "g": {"resin_scattering_per_mm": SCATTERING_PER_MM, "resin_asymmetry": ASYMMETRY},
}
#: All fills in the presets, the first and last in the fitted set.
FILLS_OF = {"thesis-32in": tuple(FILLS), "thesis-fitted": (0.10, 1.0)}
#: Which of them are traced with and without the top sheet.
SERIES = {"mpf": ("filled", "mie", "g"), "mpf-no-top": ("filled", "g")}


@dataclass(frozen=True)
class FillCase(Case):
    """A film in the MPF's stack, or in that without the top sheet, with a resin of `RESIN`."""

    resin: str = "filled"
    top_sheet: bool = True

    def stack(self) -> Stack:
        """Return the stack with the mesh of the film without resin, where the resin scatters."""
        stack = read_stack(self.preset, overrides=RESIN[self.resin])
        if not self.top_sheet:
            stack = replace(stack, layers=stack.layers[:-1])
        return stack.with_prism(self._prism()) if RESIN[self.resin] else stack

    def identity(self, stack: Stack) -> list:
        """Return all that a figure depends on but the code and effort."""
        return [*super().identity(stack), file_hash(self._prism())]

    def _prism(self) -> Path:
        return film_mesh("filled", EMPTY)


def fill_cases(values: str) -> list[FillCase]:
    """Return the films of fills and resins in the stacks of one set of values."""
    return [
        FillCase(f"{stack} {resin} {c:g}", f"{values}-mpf", "filled", c, resin, stack == "mpf")
        for stack, resins in SERIES.items()
        for resin in resins
        for c in (FILLS[fill] for fill in FILLS_OF[values])
    ]
