"""Words that pages say of more than one kind of film."""

from typing import Any

from numpy.typing import NDArray

#: Said under every plot of C.
CURVATURE_WORDS = "C of z = z_{0} + C/2 · x² through the tips"

#: Said under a plot of C over a cell of LEDs, whose corner is the middle of the light.
CORNER_WORDS = (
    "The lower left corner is x = y = 0, where a lattice has an LED; the map of the light has "
    "that place in its middle."
)


def size_words(size: tuple[float, ...], number: str) -> str:
    """Return a size [mm] and what there is of it, in words."""
    return " × ".join(f"{part:.6g}" for part in size) + f" mm, {number}"


def range_words(curvature: NDArray[Any]) -> str:
    """Return the least and the largest curvature [1/mm]; once where they are the same."""
    low, high = f"{curvature.min():.4g}", f"{curvature.max():.4g}"
    return low if low == high else f"{low} … {high}"


def view_text(what: str, how: str, file: str = "film.stl") -> str:
    """Return what a three-dimensional drawing shows."""
    return (
        f"{what} in the middle of the piece {how}; turn with the mouse. The surface is that of "
        f"{file}; the base goes on below."
    )
