"""The curvature map C(x, y): its values, its NPZ file, and the pieces that a groove falls into."""
