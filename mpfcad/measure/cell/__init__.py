"""Luminance over a cell that repeats along x and y: its Fourier series, contrast, points, map."""
