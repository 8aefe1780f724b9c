"""STEP files read back: their bodies, their text, assemblies of a library."""
