"""The lamps' cavity, endless or finite, and what the lamps give directly."""
