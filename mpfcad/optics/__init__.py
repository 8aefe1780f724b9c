"""The tracer: double precision, no offsets, counter-based random numbers; it knows only meshes.

`read_film_mesh` reads and checks a closed mesh; `build_scene` lowers elements (cavity, slab, sheet,
film) to flat arrays; `engine.trace` follows paths through them. `reference` is the slow oracle that
the tests hold the kernels against. Nothing here is imported from film, mask or cad.
"""
