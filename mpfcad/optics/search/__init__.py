"""Accelerators: where a ray meets a film next, by chain, section, grid or tree."""
