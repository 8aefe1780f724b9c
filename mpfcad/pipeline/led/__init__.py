"""Films under LEDs: made as libraries of pieces, designed by their harmonics, traced from files."""
