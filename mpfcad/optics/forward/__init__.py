"""Forward traces of small sources, connected to the meter at the topmost scattering sheet."""
