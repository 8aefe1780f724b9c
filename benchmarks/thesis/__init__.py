"""The published work beside ours: its figures, the cases that make them, their fit and their page.

`fit_stack.py` and `reproduce.py` beside this folder are the commands.
"""
