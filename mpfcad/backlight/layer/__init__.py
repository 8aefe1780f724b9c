"""Layers of a stack: what a file states of them, and how each becomes elements of the trace."""
