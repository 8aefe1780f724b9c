"""`mpfcad init`: a commented job to start from."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    path: Annotated[Path, typer.Argument(metavar="[PATH]", help="The job to write.")] = Path(
        "job.toml"
    ),
) -> int:
    """Write a commented job; an existing file is never replaced."""
    from mpfcad.errors import InputError
    from mpfcad.job import TEMPLATE

    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(TEMPLATE)
    except FileExistsError:
        raise InputError(f"{path}: exists: expected a new file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
    print(path)
    return 0
