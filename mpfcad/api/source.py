"""Where a job, design or sweep comes from: a TOML file, or a dict with a folder for its files."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel

Model = TypeVar("Model", bound=BaseModel)


def read_source(
    model: type[Model], source: str | Path | Mapping[str, Any], folder: str | Path | None
) -> tuple[Model, Path]:
    """Return the model and the path that its relative file names are taken from.

    A dict has no file: its path is `NAME.toml` in `folder` (None: the working folder), which need
    not exist.

    Raises
    ------
    InputError
        naming the first field that is wrong, its value and what is expected.
    """
    from mpfcad.job.reader import read_document, validate

    if isinstance(source, Mapping):
        built = validate(model, dict(source), str(source.get("name", "dict")))
        return built, Path(folder or ".") / f"{source.get('name', 'dict')}.toml"
    path = Path(source)
    return validate(model, read_document(path), str(path)), path
