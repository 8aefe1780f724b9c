"""What a fit of a stylus trace leaves open: intervals of curvature and fill."""
