"""A backlight's values from measurements: data read, traces with values changed, results."""
