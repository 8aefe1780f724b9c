"""Films as a library of groove pieces and a map of which stands where: held, read and traced."""
