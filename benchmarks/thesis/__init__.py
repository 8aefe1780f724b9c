"""The published work beside ours: the cases that make its figures, their fits and their page.

`reproduce.py` beside this folder is the command; `fit-simulated.toml` and `fit-measured.toml` are
what `mpfcad fit` takes.
"""
