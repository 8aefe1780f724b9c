"""Light in bands of wavelengths: one path for all of them, and layers that convert light.

A kernel that light passes through takes `hue`: what a path weighs at each band, or None for light
of one wavelength, when the branch that would use it is not compiled.
"""
