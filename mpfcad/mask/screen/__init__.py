"""The screen that carries the mask: fabric against apertures, beats with prism and pixel."""
