"""The fitted backlight as files: a stack with widths, and the covariance of its values."""

import os
from pathlib import Path
from typing import Any

from mpfcad.backlight import Stack, read_stack
from mpfcad.backlight.written import quantity_table
from mpfcad.job.fit import Fit
from mpfcad.pipeline.fit.sought import LUMINANCE


def stack_text(fit: Fit, file: Path, stack: Stack, record: dict[str, Any], folder: Path) -> str:
    """Return the stack's TOML: what the fit's backlight extends, and every value that differs.

    `folder`: where it will lie; a backlight in a file is named from there.
    """
    import tomli_w

    table = fit.stack
    if table.file is not None:
        base = (file.parent / table.file).resolve()
        extends = Path(os.path.relpath(base, folder)).as_posix()
        plain = read_stack(base)
    else:
        extends = table.preset or ""
        plain = read_stack(extends)
    value = {
        name: quantity_table(entry)
        for name, entry in stack.quantity.items()
        if entry != plain.quantity.get(name)
    }
    doubt = "; its measurements contradict each other" if record["contradicts"] else ""
    doubt += "" if record["settled"] else "; not settled"
    for row in record["values"]:
        value[row["name"]] = {
            "value": row["value"],
            # It changes no contrast, so no confidence asks for its width.
            **({} if row["name"] == LUMINANCE else {"sigma": row["sigma"]}),
            "tag": "given",
            "source": f"mpfcad fit {fit.name}: {row['value']:.5g} ± {row['sigma']:.2g}{doubt}",
        }
    document = {"extends": extends, "title": f"{stack.title}; fitted: {fit.name}", "value": value}
    return tomli_w.dumps(document)


def covariance_text(record: dict[str, Any]) -> str:
    """Return the covariance as `confidence.covariance` reads it; without the lamps' luminance."""
    names, matrix = record["covariance"]["names"], record["covariance"]["matrix"]
    kept = [i for i, name in enumerate(names) if name != LUMINANCE]
    lines = [",".join(names[i] for i in kept)]
    lines += [",".join(repr(matrix[i][j]) for j in kept) for i in kept]
    return "\n".join([*lines, ""])
