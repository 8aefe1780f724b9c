"""The subcommands in groups, with an example of each, as `--help` shows them."""

from typing import Any

from typer.core import TyperCommand, TyperGroup

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
        "calibrate": "mpfcad calibrate trace.csv --aperture 0.1 --out process.toml",
    },
    "Housekeeping": {
        "cache": "mpfcad cache --prune",
    },
}
#: Characters of a description that are shown: all.
_WHOLE = 500
EXAMPLES = {name: example for group in GROUPS.values() for name, example in group.items()}


class GroupedHelp(TyperGroup):
    """The list of subcommands, in the groups above; what stands in none comes last."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the groups, each with its subcommands in order."""
        known = {name: self.get_command(ctx, name) for name in self.list_commands(ctx)}
        rest = {name: "" for name in known if name not in EXAMPLES}
        for title, names in {**GROUPS, "Others": rest}.items():
            rows = [
                (name, command.get_short_help_str(_WHOLE))
                for name in names
                if (command := known.get(name)) is not None
            ]
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)


class ExampleHelp(TyperCommand):
    """A subcommand whose help ends with an example on a line of its own."""

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write the example."""
        example = EXAMPLES.get(self.name or "")
        if example:
            with formatter.section("Example"):
                formatter.write_text(example)
