"""One passage through a film, ray by ray or eight rays at once, with scattering resin."""
