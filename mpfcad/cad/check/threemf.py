"""A 3MF file of ours, read back by lib3mf."""

from pathlib import Path
from typing import Any

from mpfcad.errors import ExportError


def read_model(path: Path) -> Any:
    """Return the lib3mf model of a file whose unit is mm.

    Raises
    ------
    ExportError
        when lib3mf cannot read it, or its unit is another.
    """
    import lib3mf

    model = lib3mf.Wrapper().CreateModel()
    try:
        model.QueryReader("3mf").ReadFromFile(str(path))
    except lib3mf.ELib3MFException as error:
        raise ExportError(f"{path.name}: lib3mf cannot read this file: {error}") from error
    if model.GetUnit() != lib3mf.ModelUnit.MilliMeter:
        raise ExportError(f"{path.name}: unit {model.GetUnit()}: expected mm")
    return model
