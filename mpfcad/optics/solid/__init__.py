"""Closed meshes: read, checked that they bound a solid, repaired when asked."""
