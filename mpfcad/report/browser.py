"""A page as PDF or picture, by a Chromium that is installed; nothing else draws its plots."""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from mpfcad.errors import ExportError, InputError

#: Names of browsers that print without a window, in the order they are looked for.
BROWSERS = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "msedge",
    "microsoft-edge",
)
VARIABLE = "MPFCAD_BROWSER"
#: Nothing leaves the machine: a page needs no network, and the browser shall not use it.
OPTIONS = (
    "--headless",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-extensions",
    "--disable-sync",
    "--no-first-run",
    "--no-pings",
    "--host-resolver-rules=MAP * ~NOTFOUND",
)
_PATIENCE_S = 120
_DATE = re.compile(rb"/(CreationDate|ModDate) \(D:\d{14}")


def find_browser() -> str:
    """Return the path of a Chromium.

    Raises
    ------
    InputError
        when there is none, saying what to do.
    """
    wanted = os.environ.get(VARIABLE)
    for name in (wanted,) if wanted else BROWSERS:
        path = shutil.which(name)
        if path:
            return path
    looked = f"{VARIABLE} = {wanted}" if wanted else ", ".join(BROWSERS)
    raise InputError(
        f"--pdf: no Chromium found: expected one of {looked}; install one, name it in "
        f"{VARIABLE}, or print report.html from a browser"
    )


def write_pdf(page: Path, path: Path, browser: str, paper: str = "A4") -> None:
    """Print the page to `path`, on `A4` or `letter`; the same page and browser give the same bytes.

    Raises
    ------
    ExportError
        when the browser writes no PDF.
    """
    style = f"@page {{ size: {paper}; }}"
    _show(
        page, path, browser, style, ("--no-pdf-header-footer", f"--print-to-pdf={path.resolve()}")
    )
    if not path.is_file() or not path.read_bytes().startswith(b"%PDF"):
        raise ExportError(f"{path}: {browser} wrote no PDF")
    path.write_bytes(without_dates(path.read_bytes()))


def write_screenshot(
    page: Path,
    path: Path,
    browser: str,
    size: tuple[int, int],
    *,
    style: str = "",
    target: str = "",
) -> None:
    """Write a PNG of the page's first screen, `size` pixels across and down.

    `style` is added to the page's style sheet; `target` is a part that is unfolded.

    Raises
    ------
    ExportError
        when the browser writes no picture.
    """
    window = f"--window-size={size[0]},{size[1]}"
    options = ("--hide-scrollbars", window, f"--screenshot={path.resolve()}")
    _show(page, path, browser, style, options, target)
    if not path.is_file():
        raise ExportError(f"{path}: {browser} wrote no picture")


def _show(
    page: Path, path: Path, browser: str, style: str, options: tuple[str, ...], target: str = ""
) -> None:
    """Have a browser of its own show a page, a style sheet added, and end."""
    with tempfile.TemporaryDirectory() as profile:
        sized = Path(profile) / "page.html"
        text = page.read_text("utf-8").replace("</head>", f"<style>{style}</style></head>", 1)
        sized.write_text(text, "utf-8")
        command = [
            browser,
            *OPTIONS,
            # A container's user often may not make the namespaces of the browser's sandbox.
            *(("--no-sandbox",) if hasattr(os, "geteuid") and os.geteuid() == 0 else ()),
            f"--user-data-dir={profile}/browser",
            "--virtual-time-budget=10000",
            *options,
            sized.as_uri() + (f"#{target}" if target else ""),
        ]
        try:
            subprocess.run(command, capture_output=True, timeout=_PATIENCE_S, check=False)
        except subprocess.TimeoutExpired:
            raise ExportError(f"{path}: {browser} did not end within {_PATIENCE_S} s") from None


def without_dates(content: bytes) -> bytes:
    """Return a PDF whose dates are those of the year 2000, in as many bytes."""
    return _DATE.sub(rb"/\1 (D:20000101000000", content)
