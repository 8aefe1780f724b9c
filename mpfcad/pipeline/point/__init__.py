"""One film traced in one stack, kept once it is done: what sweeps and designs are made of."""
