"""The typer application: its global options and the list of subcommands."""

import os
from typing import Annotated

import typer

from mpfcad.cli.check import cache, doctor, sign, verify, view
from mpfcad.cli.group import ExampleHelp, GroupedHelp
from mpfcad.cli.make import cad, design, init, mask, mould, run, sweep
from mpfcad.cli.measure import (
    bsdf,
    calibrate,
    compare,
    correct,
    judge,
    measure,
    stacks,
    trace,
)

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


_COMMANDS = (
    run, mask, cad, mould, trace, measure, compare, verify, view, design, sweep, bsdf, calibrate,
    judge, correct, stacks, cache, init, doctor, sign,
)  # fmt: skip

for command in _COMMANDS:
    app.command(command.__name__.rpartition(".")[2], cls=ExampleHelp)(command.command)
