"""The sweep command: points to a dataset and a page."""
