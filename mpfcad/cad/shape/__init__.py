"""The film's surface as facets, for every kind of film, and the mould of it."""
