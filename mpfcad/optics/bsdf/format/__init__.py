"""BSDF files, a module a format: read into matrices by (way, side), and written."""
