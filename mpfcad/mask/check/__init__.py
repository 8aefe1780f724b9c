"""Mask files read back and checked: ratios, design rules, markers, preview."""
