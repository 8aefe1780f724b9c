"""Stokes vectors along a path: polarised light, as an option of every element.

A kernel that light passes through takes `light`: the state of a path, or None for unpolarised
light, when the branch that would use it is not compiled.
"""
