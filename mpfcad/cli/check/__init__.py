"""Subcommands that check an export or the machine, show them and keep them."""
