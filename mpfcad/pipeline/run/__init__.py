"""A job's way: make the files, examine them from disk, record, verify."""
