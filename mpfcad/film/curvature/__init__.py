"""The curvature map C(x): its values, and the CSV that states it."""
