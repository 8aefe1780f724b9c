"""BSDF tables: files of all formats read and written, and a passage through a tabled sheet."""
