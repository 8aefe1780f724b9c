"""The design command: search, traces, the slimmest thickness."""
