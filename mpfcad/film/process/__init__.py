"""The printing process: aperture ratio, fill and curvature, and the calibration between them."""
