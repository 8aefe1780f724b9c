"""The typer application and its global options; `group` has the subcommands."""

import os
from typing import Annotated

import typer

from mpfcad.cli.group import GroupedHelp

_DEBUG = "MPFCAD_DEBUG"

app = typer.Typer(
    name="mpfcad",
    help="From a curvature map to a verified multi-performance film.",
    epilog=(
        "Exit codes: 0 PASS or MARGINAL, 1 FAIL or INCONCLUSIVE, 2 bad input, 3 anything else, "
        "4 verify found an export changed."
    ),
    no_args_is_help=False,
    cls=GroupedHelp,
    add_completion=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def debug_wanted() -> bool:
    """Tell whether errors shall show their traceback."""
    return os.environ.get(_DEBUG, "") not in ("", "0")


def _print_version(wanted: bool) -> None:
    if wanted:
        from mpfcad import __version__

        print(f"mpfcad {__version__}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def _global_options(
    context: typer.Context,
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print version."),
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    if debug:
        os.environ[_DEBUG] = "1"
    if context.invoked_subcommand is None:
        print(context.get_help())
