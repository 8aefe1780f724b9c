"""Exports looked at in a browser: a server on this machine, a gallery, a comparison of two."""

from mpfcad.report.view.gallery import Export, find_exports
from mpfcad.report.view.server import ViewServer

__all__ = ["Export", "ViewServer", "find_exports"]
