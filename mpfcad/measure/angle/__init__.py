"""Luminance over direction: cuts, viewing angles, conoscope."""
