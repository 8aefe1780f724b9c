"""Stylus traces: what a tip makes of a groove, and the curvature and fill fitted to them."""
