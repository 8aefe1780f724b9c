"""Lamp-Mura contrast: harmonics fitted to luminance over the pitch, and their intervals."""
