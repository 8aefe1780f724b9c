"""`mpfcad verify`: hash every file of an export, then find its figures again from its files."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from mpfcad.cli.character import print_json
from mpfcad.cli.option import Json, Junit, Threads

#: Exit code of an export of which a file is changed or a figure differs; its verdict is void.
CHANGED = 4


def command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="An export of mpfcad run.")],
    threads: Threads = None,
    json: Json = False,
    junit: Junit = None,
    key: Annotated[
        Path | None,
        typer.Option(
            "--key",
            metavar="FILE",
            help="Check the signature too: a public key, or allowed_signers.",
        ),
    ] = None,
) -> int:
    """Check every hash of an export, then trace its film again and compare bit for bit."""
    from mpfcad.cli.stream import one_line
    from mpfcad.cli.terminal import Terminal, print_verdict
    from mpfcad.errors import ExportError
    from mpfcad.export.signature import check_signature
    from mpfcad.pipeline import verify_export
    from mpfcad.record import check_junit, exit_code, write_junit

    check_junit(junit)
    changed: str | None = None
    verification: dict[str, Any] = {}
    rounded: list[Any] = []
    try:
        signer = None if key is None else check_signature(folder, key)
        with Terminal() as terminal:
            verification = verify_export(
                folder, threads=threads, progress=terminal, rounded=rounded
            )
    except ExportError as error:
        changed = str(error)
    if junit is not None:
        write_junit(junit, verification, changed=changed)
    if json:
        print_json(_result(verification, changed))
    if changed is not None:
        print(f"mpfcad: {one_line(changed)}", file=sys.stderr)
        return CHANGED
    if not json:
        if signer is not None:
            print(f"signed: {signer}")
        print(f"verified: every hash holds, and the figures come out the same{_bits(rounded)}")
        print_verdict(verification, folder)
    return exit_code(verification["verdict"])


def _bits(rounded: list[Any]) -> str:
    """Return in words how exactly the figures came out."""
    if not rounded:
        return " bit for bit"
    most = max(one.share for one in rounded)
    return (
        f"; {len(rounded)} of them differ in their last bits, by up to {most:.1g} of their value, "
        "as another processor rounds"
    )


def _result(verification: dict[str, Any], changed: str | None) -> dict[str, Any]:
    """Return what `--json` prints; of a changed export the verdict is not to be trusted."""
    verified = changed is None
    return {
        "schema": 1,
        "verified": verified,
        "changed": changed,
        "name": verification.get("name") if verified else None,
        "verdict": verification["verdict"] if verified else None,
        "gates": verification["gates"] if verified else [],
    }
