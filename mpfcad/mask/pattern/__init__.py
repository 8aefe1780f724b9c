"""Film to apertures: the ratio of each groove, and the patterns that realise it."""
