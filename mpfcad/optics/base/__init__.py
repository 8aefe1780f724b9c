"""What all kernels rest on: compiling, lanes, random numbers, Fresnel, phases, tallies."""
