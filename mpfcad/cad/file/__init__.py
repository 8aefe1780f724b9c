"""Facets and sections to files: STL, PLY, 3MF, DXF, height maps."""
