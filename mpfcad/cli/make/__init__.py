"""Subcommands that start a job, make its files or find its map."""
