"""Whether an element is its own mirror image."""


class Mirrored:
    """What is its own mirror image at x = 0 and at y = 0, unless it says otherwise."""

    def is_mirrored(self, period: float) -> bool:
        """Tell whether it counts as such over a cell of at least `period` [mm] along x and y."""
        return True
