"""Triangles in a tree of boxes, eight wide: built, split, walked."""
