"""`mpfcad init`: a commented job to start from."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    path: Annotated[Path, typer.Argument(metavar="[PATH]", help="The job to write.")] = Path(
        "job.toml"
    ),
) -> int:
    """Write a commented job of the file's name; an existing file is never replaced."""
    from mpfcad.errors import InputError
    from mpfcad.job import TEMPLATE, TEMPLATE_NAME, build_job

    name = build_job({"name": path.stem, "map": {"curvature_per_mm": 60.0}}, str(path)).name
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(TEMPLATE.replace(TEMPLATE_NAME, name))
    except FileExistsError:
        raise InputError(f"{path}: exists: expected a new file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
    print(path)
    print(f"next: mpfcad run {path} --effort quick; the results go to exports/{name}")
    return 0
