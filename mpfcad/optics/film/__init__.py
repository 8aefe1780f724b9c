"""One passage through a film, ray by ray or many in lanes, with scattering resin."""
