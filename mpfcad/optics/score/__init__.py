"""Derivatives of the light by every smooth value of a scene, from the paths of one trace."""
