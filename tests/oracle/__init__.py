"""The oracle: the tracer again in plain Python, path by path, slow and readable."""
