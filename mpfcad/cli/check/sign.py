"""`mpfcad sign`: an export's manifest signed with a key of ssh."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="An export of mpfcad.")],
    key: Annotated[
        Path, typer.Option("--key", metavar="FILE", help="Private key, as ssh-keygen makes it.")
    ],
) -> int:
    """Sign an export; mpfcad verify --key checks it with the public key."""
    from mpfcad.errors import ExportError, InputError
    from mpfcad.export.signature import sign_export

    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder: expected an export of mpfcad")
    try:
        print(sign_export(folder, key))
    except ExportError as error:
        raise InputError(str(error)) from None
    return 0
