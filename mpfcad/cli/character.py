"""Text that reads in any encoding: signs that one lacks get a plain stand-in, JSON its escapes."""

import codecs
import json
import sys
from typing import Any

#: The name of the error handler of streams.
HANDLER = "mpfcad"
#: What stands for a sign that an encoding lacks.
PLAIN = {
    "≤": "<=", "≥": ">=", "±": "+-", "→": "->", "←": "<-", "↑": "^", "…": "...", "–": "-",
    "−": "-", "·": "*", "×": "x", "µ": "u", "μ": "u", "²": "2", "³": "3", "°": " deg", "σ": "sigma",
    "δ": "delta", "Δ": "Delta", "Σ": "sum", "χ": "chi", "½": "1/2", "‘": "'", "’": "'", "“": '"',
    "”": '"', "∞": "inf", "√": "sqrt", "λ": "lambda", "θ": "theta",
}  # fmt: skip


def register_handler() -> str:
    """Register the error handler by which `≤` becomes `<=` in cp1252; return its name."""
    codecs.register_error(HANDLER, _plain)
    return HANDLER


def print_json(value: Any) -> None:
    """Print a value as JSON; escaped where the encoding lacks a sign, so that nothing is lost."""
    encoding = (getattr(sys.stdout, "encoding", None) or "").lower()
    print(json.dumps(value, indent=1, ensure_ascii=not encoding.startswith("utf")))


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    wrong = error.object[error.start : error.end]
    return "".join(_in_encoding(sign, error.encoding) for sign in wrong), error.end


def _in_encoding(sign: str, encoding: str) -> str:
    """Return a sign's stand-in, or its escape where it has none."""
    text = PLAIN.get(sign)
    return sign.encode(encoding, "backslashreplace").decode(encoding) if text is None else text
