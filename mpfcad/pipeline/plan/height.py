"""Formats of height maps."""

#: Suffixes of `cad.file.height`.
HEIGHT_FORMATS = ("tif", "dat")
