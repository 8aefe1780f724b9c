"""Which inputs of a job are not known exactly, traces with them changed, and what follows."""
