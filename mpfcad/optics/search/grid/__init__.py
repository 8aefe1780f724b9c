"""Uniform grids that a ray walks cell by cell: over the facets of a top, over a cross-section."""
