"""Subcommands that trace and measure light, and those that read what was printed."""
