"""TOML file -> Job, and whatever is wrong in one line: file, field, value, what is expected."""

from pathlib import Path
from types import NoneType
from typing import Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from mpfcad.boundary import guarded, read_toml
from mpfcad.errors import InputError
from mpfcad.job.model import Job

Model = TypeVar("Model", bound=BaseModel)
#: What a job's name has to begin with.
_FIRST = ", the first a letter or digit"


def build_job(document: dict[str, Any], where: str) -> Job:
    """Return the job of a parsed TOML `document`; `where` names its file in errors.

    Raises
    ------
    InputError
        naming the first field that is wrong, its value and what is expected.
    """
    return validate(Job, document, where)


def validate(model: type[Model], document: dict[str, Any], where: str) -> Model:
    """Return `document` as a `model`; `where` names its file in errors.

    Raises
    ------
    InputError
        naming the first field that is wrong, its value and what is expected.
    """
    with guarded(where, "plain values"):
        try:
            return model.model_validate(document)
        except ValidationError as error:
            raise InputError(f"{where}: {_first_line(error, model)}") from None


def read_job(path: Path) -> Job:
    """Return the job in the TOML file at `path`.

    Raises
    ------
    InputError
        when the file cannot be read, is no TOML (naming the line), or a field is wrong.
    """
    return build_job(read_document(path), str(path))


def read_document(path: Path) -> dict[str, Any]:
    """Return what is in a TOML file.

    Raises
    ------
    InputError
        when the file cannot be read or is no TOML (naming the line).
    """
    return read_toml(path)


def _first_line(error: ValidationError, root: type[BaseModel]) -> str:
    """Return `field: value: what is expected` of the first error, and how many more there are."""
    errors = error.errors(include_url=False)
    first = errors[0]
    field = ".".join(str(part) for part in first["loc"]) or "job"
    if first["type"] == "missing":
        line = f"{field}: missing: expected a value"
    elif first["type"] == "extra_forbidden":
        known = _known_keys(root, first["loc"][:-1])
        line = f"{field}: {_shown(first['input'])}: unknown key; {known}"
    else:
        shown = first["input"]
        quoted = isinstance(shown, str) and first["type"].endswith(("_type", "_parsing"))
        line = f"{field}: {_shown(repr(shown) if quoted else shown)}: {_expected(dict(first))}"
    more = len(errors) - 1
    return line + (f" (and {more} more error{'s' if more > 1 else ''})" if more else "")


def _expected(error: dict[str, Any]) -> str:
    """Return what is expected of a field, from pydantic's message."""
    kind, details = error["type"], error.get("ctx", {})
    if kind == "string_pattern_mismatch":
        length, first = (16, "") if "{1,16}" in details["pattern"] else (64, _FIRST)
        return f"expected 1 to {length} letters, digits, '.', '_' or '-'{first}"
    if kind in ("model_type", "dict_type"):
        return "expected a table"
    if kind in ("too_short", "too_long"):
        count = details.get("min_length", details.get("max_length"))
        most = "at least" if kind == "too_short" else "at most"
        return f"expected {most} {count} item{'s' if count != 1 else ''}"
    message = error["msg"].removeprefix("Value error, ")
    return message.replace("Input should be", "expected", 1)


def _shown(value: Any) -> str:
    """Return `value` on one short line; a whole table is shown by its keys."""
    if isinstance(value, dict):
        return "{" + ", ".join(map(str, value)) + "}"
    text = str(value).replace("\n", " ")
    return text if len(text) <= 60 else text[:57] + "..."


def _known_keys(root: type[BaseModel], location: tuple[Any, ...]) -> str:
    """Return the keys that the table at `location` in a `root` knows."""
    model: Any = root
    for part in location:
        if get_origin(model) in (list, dict):
            model = get_args(model)[-1]
        else:
            model = _table_of(model.model_fields[part].annotation)
    keys = [field.alias or name for name, field in model.model_fields.items()]
    return "known: " + ", ".join(keys)


def _table_of(annotation: Any) -> Any:
    """Return the model of a table that may be left out (`Table | None`), or of one that may not.

    Of tables in a list or by name it is the list or dict of models.
    """
    if get_origin(annotation) in (list, dict):
        return annotation
    return next((kind for kind in get_args(annotation) if kind is not NoneType), annotation)
