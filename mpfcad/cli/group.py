"""The subcommands in groups, with an example of each, as `--help` shows them.

A subcommand is built when it is asked for: its options cost more time than all else of `--help`.
"""

from collections.abc import Callable, Iterator, MutableMapping
from importlib import import_module
from inspect import getdoc
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from mpfcad.cli.narrow import Context

#: Package of `mpfcad.cli` -> its subcommands, each the function `command` of the module so named.
PLACES = {
    "make": ("run", "mask", "cad", "mould", "design", "sweep", "init"),
    "measure": (
        "trace", "measure", "compare", "rays", "bsdf", "calibrate", "judge", "correct", "fit",
        "stacks",
    ),
    "check": ("verify", "view", "cache", "doctor", "sign"),
}  # fmt: skip

#: Group -> subcommand -> example.
GROUPS = {
    "Start": {
        "init": "mpfcad init my-film.toml",
        "stacks": "mpfcad stacks",
        "doctor": "mpfcad doctor",
    },
    "Make a film": {
        "run": "mpfcad run masks/patterned-16mm.toml --effort quick",
        "mask": "mpfcad mask masks/uniform-c60.toml --format oas,gbr",
        "cad": "mpfcad cad masks/uniform-c60.toml --format step,3mf",
        "mould": "mpfcad mould masks/uniform-c60.toml --shrinkage 0.004",
    },
    "Find a film": {
        "design": "mpfcad design masks/design-16mm.toml",
        "sweep": "mpfcad sweep masks/sweep-uniform.toml",
    },
    "Measure light": {
        "trace": "mpfcad trace film.stl --stack thesis-32in-mpf --thickness-mm 16",
        "measure": "mpfcad measure exports/patterned-16mm --what angular,flux",
        "compare": "mpfcad compare exports/patterned-16mm thesis-32in-conventional",
        "rays": "mpfcad rays exports/patterned-16mm --out screen.tm25ray",
        "bsdf": "mpfcad bsdf film.stl --format klems --page",
    },
    "Check and show": {
        "verify": "mpfcad verify exports/patterned-16mm --json",
        "sign": "mpfcad sign exports/patterned-16mm --key ~/.ssh/id_ed25519",
        "view": "mpfcad view exports",
    },
    "Measure prints": {
        "judge": "mpfcad judge luminance.csv --against exports/patterned-16mm",
        "correct": "mpfcad correct exports/patterned-16mm --measured seen.csv --lamp-at-mm 5.3",
        "fit": "mpfcad fit fit.toml --effort quick",
        "calibrate": "mpfcad calibrate trace.csv --aperture 0.1 --out process.toml",
    },
    "Housekeeping": {
        "cache": "mpfcad cache --prune",
    },
}
EXAMPLES = {name: example for group in GROUPS.values() for name, example in group.items()}


def function_of(name: str) -> Callable[..., Any]:
    """Return what a subcommand calls."""
    package = next(package for package, names in PLACES.items() if name in names)
    function: Callable[..., Any] = import_module(f"mpfcad.cli.{package}.{name}").command
    return function


class Commands(MutableMapping[str, Any]):
    """The subcommands by name, each built when it is first taken."""

    def __init__(self) -> None:
        self._names = [name for names in PLACES.values() for name in names]
        self._built: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        if name not in self._names:
            raise KeyError(name)
        if name not in self._built:
            alone = typer.Typer(
                add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False
            )
            alone.command(name, cls=ExampleHelp)(function_of(name))
            self._built[name] = typer.main.get_command(alone)
        return self._built[name]

    def __setitem__(self, name: str, command: Any) -> None:
        self._names = [*(one for one in self._names if one != name), name]
        self._built[name] = command

    def __delitem__(self, name: str) -> None:
        self._names.remove(name)
        self._built.pop(name, None)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


class GroupedHelp(TyperGroup):
    """The list of subcommands, in the groups above."""

    context_class = Context

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = Commands()

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the groups, each with its subcommands in order."""
        for title, names in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([(name, self._description(name)) for name in names])

    def _description(self, name: str) -> str:
        """Return the first paragraph of a subcommand's docstring."""
        words = getdoc(function_of(name)) or ""
        return " ".join(words.partition("\n\n")[0].split())


class ExampleHelp(TyperCommand):
    """A subcommand whose help ends with an example on a line of its own."""

    context_class = Context

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write the example."""
        example = EXAMPLES.get(self.name or "")
        if example:
            with formatter.section("Example"):
                formatter.write_text(example)
