"""Stylus traces: read, and the curvature and fill fitted to them."""
