"""What a job, a design, a sweep and a fit have in common: where they come from, and their name."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from pydantic import BaseModel


Model = TypeVar("Model", bound="BaseModel")


class Sourced(ABC, Generic[Model]):
    """What is made from a TOML file, or from a dict with a folder for its files."""

    def __init__(
        self, source: str | Path | Mapping[str, Any], *, folder: str | Path | None = None
    ) -> None:
        self.model, self.file = read_source(self._model_class(), source, folder)

    @staticmethod
    @abstractmethod
    def _model_class() -> type[Model]:
        """Return the model, imported when it is needed."""

    @property
    def name(self) -> str:
        """Its name; exports go to a folder of that name unless told otherwise."""
        model: Any = self.model  # each of them has one
        return str(model.name)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"


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
