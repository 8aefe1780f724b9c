"""`mpfcad view`: exports in the browser, served to this machine alone."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="DIR|FILE", help="Folder of exports, an export, or one of its files."
        ),
    ] = Path("exports"),
    port: Annotated[
        int, typer.Option("--port", min=0, max=65535, help="Port; 0: any that is free.")
    ] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the address in a browser.")
    ] = True,
) -> int:
    """Show exports in a browser: reports, files, a gallery, two beside each other."""
    from mpfcad.errors import InputError
    from mpfcad.report.view import ViewServer

    if not path.exists():
        raise InputError(f"{path}: no such folder or file: expected an export of mpfcad run")
    folder, page = (path, "") if path.is_dir() else (path.parent, path.name)
    try:
        server = ViewServer(folder, port)
    except OSError as error:
        raise InputError(f"--port: {port}: {error.strerror}: expected a free port") from None
    address = server.address + page
    print(
        f"{address}\nCtrl-C ends it; the address holds for this machine and this run.", flush=True
    )
    if browser:
        import webbrowser

        webbrowser.open(address)
    with server:
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            return 0
    return 0
