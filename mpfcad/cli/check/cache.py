"""`mpfcad cache`: what is kept of finished work, and its removal."""

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from mpfcad.store.entry import Entry

_STATES = {
    "kept": "",
    "old": "of another version",
    "damaged": "damaged, set aside",
    "part": "left by a killed run",
}


def command(
    prune: Annotated[
        bool, typer.Option("--prune", help="Remove what this version of mpfcad cannot use.")
    ] = False,
    days: Annotated[
        float | None,
        typer.Option(
            "--older-than",
            min=0,
            metavar="DAYS",
            help="With --prune: also remove entries not used since.",
        ),
    ] = None,
    everything: Annotated[
        bool, typer.Option("--all", help="With --prune: remove every entry.")
    ] = False,
) -> int:
    """Show what is kept of finished work, or remove it; deleting it is always safe."""
    from mpfcad.errors import InputError
    from mpfcad.store import cache_folder
    from mpfcad.store.entry import list_entries
    from mpfcad.store.entry import prune as remove
    from mpfcad.store.kernel import kernel_folder

    if (days is not None or everything) and not prune:
        raise InputError("--older-than, --all: expected together with --prune")
    for folder in dict.fromkeys((cache_folder(), kernel_folder())):
        if prune:
            gone = remove(folder, days=days, everything=everything)
            size = sum(entry.size for entry in gone)
            print(f"{folder}: removed {len(gone)} files, {_megabytes(size)}")
        _show(folder, list_entries(folder))
    return 0


def _show(folder: object, entries: "list[Entry]") -> None:
    from mpfcad.store.keep import KINDS

    print(f"{folder}: {len(entries)} files, {_megabytes(sum(e.size for e in entries))}")
    for kind, words in KINDS.items():
        for state, note in _STATES.items():
            some = [e for e in entries if (e.kind, e.state) == (kind, state)]
            if some:
                ages = [e.age for e in some]
                size = _megabytes(sum(e.size for e in some))
                used = f"last used {min(ages):.1f} to {max(ages):.1f} days ago"
                what = words + (f" ({note})" if note else "")
                print(f"  {what:<40}{len(some):>7} {size:>12} {used}")


def _megabytes(size: float) -> str:
    return f"{size / 1e6:.2f} MB"
