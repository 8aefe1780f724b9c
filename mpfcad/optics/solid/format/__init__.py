"""Files that hold solids, a module a format, each read into bodies of corners and facets."""
