"""Colour of the screen: XYZ, x y, u'v' over the lamp pitch and over direction, colour Mura."""
