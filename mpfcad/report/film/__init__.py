"""The report of one film: its first screen and its sections."""
