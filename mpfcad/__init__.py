"""mpfcad: from a curvature map to a verified multi-performance film.

>>> import mpfcad
>>> job = mpfcad.Job({"name": "c60", "map": {"curvature_per_mm": 60.0}})
>>> job.name
'c60'

The layers, from the bottom: `units` and `errors`; `film` (what the film is); `mask`, `cad` and
`optics` (what is made of it, and how it is traced); `backlight`; `measure`; `confidence` and `fit`;
`record` and `report`; and at the top `job`, `pipeline`, `cli` and `api`, whose names stand here
too. Imports point down only; tests/test_layering.py holds it. Nothing heavy is imported before it
is used.
"""

TYPE_CHECKING = False  # as typing's; its import would be a third of this one's time
if TYPE_CHECKING:
    from mpfcad.api import (
        Design,
        DesignResult,
        Export,
        Figure,
        Fit,
        FitResult,
        Job,
        Measurement,
        Run,
        Sweep,
        SweepResult,
        Trace,
        trace,
        verify,
    )
    from mpfcad.errors import ExportError, GeometryError, InputError, TraceError

__version__ = "0.2.0"
__all__ = [
    "Design",
    "DesignResult",
    "Export",
    "ExportError",
    "Figure",
    "Fit",
    "FitResult",
    "GeometryError",
    "InputError",
    "Job",
    "Measurement",
    "Run",
    "Sweep",
    "SweepResult",
    "Trace",
    "TraceError",
    "trace",
    "verify",
]


def __getattr__(name: str) -> object:
    """Import a public name when it is first used (PEP 562)."""
    if name not in __all__:
        raise AttributeError(f"module 'mpfcad' has no attribute {name!r}")
    from importlib import import_module

    source = "mpfcad.errors" if name.endswith("Error") else "mpfcad.api"
    found: object = getattr(import_module(source), name)
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
