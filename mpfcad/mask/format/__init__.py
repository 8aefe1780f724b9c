"""Apertures to files: OASIS, GDSII, DXF, Gerber, SVG and TIFF, with the phototool's furniture."""
