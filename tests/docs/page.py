"""Pages of the documentation, their blocks of code, and the files that these name."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
#: Every page, by its name.
PAGES = {path.stem: path for path in (ROOT / "README.md", *sorted(DOCS.glob("*.md")))}
#: A block of a page: its language (`sh`: run, others: written where they name a file), its text.
_BLOCK = re.compile(r"^( *)```(\w*)\n(.*?)^\1```", re.DOTALL | re.MULTILINE)
NAMED = re.compile(r"# file: (\S+)\n")


def blocks(page):
    """Return (language, text) of each block of a page, in order."""
    text = PAGES[page].read_text("utf-8")
    return [(found[1], found[2]) for found in re.findall(_BLOCK, text)]


def write_files(page, folder):
    """Write the files that a page shows with their names; return their paths."""
    found = [(NAMED.match(text), text) for _, text in blocks(page)]
    paths = []
    for named, text in found:
        if named:
            paths.append(folder / named[1])
            paths[-1].write_text(text[named.end() :], "utf-8")
    return paths
