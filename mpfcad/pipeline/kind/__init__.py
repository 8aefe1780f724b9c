"""Kinds of film, one module each: files, checks, comparison with the mask; `kind_of` finds one."""

from mpfcad.pipeline.kind.base import Check, Kind, Print, step_header
from mpfcad.pipeline.kind.registry import kind_of

__all__ = ["Check", "Kind", "Print", "kind_of", "step_header"]
