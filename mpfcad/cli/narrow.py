"""Help in a terminal of any width: below what two columns need, each text stands under its name."""

import shutil
import textwrap
from collections.abc import Sequence
from typing import Any

from typer.core import TyperCommand

_Context: Any = TyperCommand.context_class
_Formatter: Any = _Context.formatter_class
#: Narrowest width in which names and texts stand side by side, and that of the narrowest text.
_TWO_COLUMNS, _NARROWEST = 50, 16


class Formatter(_Formatter):
    """The library's help formatter, which takes 50 columns whatever there is."""

    width: int

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.width = max(min(self.width, shutil.get_terminal_size().columns), _NARROWEST)

    def write_usage(self, prog: str, args: str = "", prefix: str | None = None) -> None:
        """Write the usage line."""
        if self.width >= _TWO_COLUMNS:
            super().write_usage(prog, args, prefix)
        else:
            self._wrap(f"{'Usage: ' if prefix is None else prefix}{prog} {args}", 0, 2)

    def write_dl(self, rows: Sequence[tuple[str, str]], *args: Any, **settings: Any) -> None:
        """Write names with their texts."""
        if self.width >= _TWO_COLUMNS:
            super().write_dl(rows, *args, **settings)
            return
        for name, text in rows:
            self._wrap(name, 2, 4)
            self._wrap(text, 4, 4)

    def _wrap(self, text: str, first: int, next: int) -> None:
        """Write text within the width; a word that is wider stays whole, to be copied."""
        lines = textwrap.wrap(
            text,
            self.width,
            initial_indent=" " * first,
            subsequent_indent=" " * next,
            break_long_words=False,
            break_on_hyphens=False,
        )
        self.write("".join(f"{line}\n" for line in lines))


class Context(_Context):
    """The context of a command whose help is so formatted."""

    formatter_class = Formatter
