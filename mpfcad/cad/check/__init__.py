"""CAD files read back and compared with the closed form and with each other."""
