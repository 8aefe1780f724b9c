"""Drawings of the film: in three dimensions, in cross-section with its sizes, its mask."""
