"""Makes the gallery: jobs that matter, each with its page's first screen as a picture.

    python docs/gallery.py [--effort quick|standard|final] [--out docs/picture] [--only NAME]

It needs a Chromium (`mpfcad doctor` says whether there is one) and writes the pictures and
docs/gallery.md.
"""

import argparse
import json
import re
import sys
from pathlib import Path

from PIL import Image, ImageChops

from mpfcad.cli import run_app
from mpfcad.report.browser import find_browser, write_screenshot

DOCS = Path(__file__).parent
MASKS = DOCS.parent / "masks"
#: Picture -> what it shows, and the command's arguments.
RUNS = {
    "patterned-16mm": ("A slim backlight: C follows the lamps", MASKS / "patterned-16mm.toml"),
    "uniform-c60": ("The thesis's best uniform film, 20 mm", MASKS / "uniform-c60.toml"),
    "bef": ("One that fails: no resin", MASKS / "bef.toml"),
    "plate": ("MPF-Plate: the grooves on the plate itself", MASKS / "gallery" / "plate.toml"),
    "moulded": ("A moulded film: no mask", MASKS / "gallery" / "moulded.toml"),
    "crossed": ("Two prism films, crossed", MASKS / "gallery" / "crossed.toml"),
    "as-made": ("Tips and valleys as a tool leaves them", MASKS / "gallery" / "as-made.toml"),
}
#: The run whose plots the README shows.
FEATURED = "patterned-16mm"
DESIGNS = {
    "design-16mm-robust": (
        "A robust film: its map is searched in place and 4 mm beside it",
        MASKS / "design-16mm-robust.toml",
    ),
}
LEDS = {
    "led-tv-20mm": "LED television: a lattice of lensed LEDs, 20 mm",
    "led-automotive-6mm": "Automotive display: LEDs, 6 mm",
    "mini-led-4mm": "Mini-LED: a chip every 4 mm",
}
SIZE, SHOWN = (1200, 1000), 800
#: Picture of one plot -> the plot, and the folded part that it stands in.
PLOTS = {"luminance": ("plot-luminance", ""), "film-3d": ("plot-grooves", "cad")}
#: Colours of a picture, so that its file is small.
_COLOURS = 255


def main() -> int:
    """Run every job and write its picture and the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--effort", default="quick")
    parser.add_argument("--out", type=Path, default=DOCS / "picture")
    parser.add_argument("--exports", type=Path, default=Path("exports/gallery"))
    parser.add_argument("--only", choices=[*RUNS, *DESIGNS, *LEDS], help="this entry alone")
    options = parser.parse_args()
    browser = find_browser()
    options.out.mkdir(parents=True, exist_ok=True)
    entries = _entries()
    for name in [options.only] if options.only else [*RUNS, *DESIGNS, *LEDS]:
        make = _make_run if name in RUNS else _make_design if name in DESIGNS else _make_measured
        entries[name] = make(name, options, browser)
        _write(entries, options.effort)
    return 0


def _make_run(name: str, options: argparse.Namespace, browser: str) -> str:
    """Run a job, write its pictures and return its entry."""
    title, job = RUNS[name]
    folder = options.exports / name
    _call(["run", str(job), "--out", str(folder), "--effort", options.effort], (0, 1))
    record = json.loads((folder / "verification.json").read_text("utf-8"))
    low, high = record["lamp_mura_contrast"]["ci95"]
    picture(folder / "report.html", options.out / f"{name}.png", browser)
    if name == FEATURED:
        for file, (plot, part) in PLOTS.items():
            plot_picture(folder / "report.html", options.out / f"{file}.png", browser, plot, part)
    result = f"**{record['verdict']}**, contrast {low:.4f} … {high:.4f} (95 %)"
    return _entry(name, title, result, f"mpfcad run {job.relative_to(MASKS.parent).as_posix()}")


def _make_design(name: str, options: argparse.Namespace, browser: str) -> str:
    """Search a film, write its page's picture and return its entry."""
    title, design = DESIGNS[name]
    folder = options.exports / name
    _call(["design", str(design), "--no-verify", "--out", str(folder)], (0, 1))
    picture(folder / "design.html", options.out / f"{name}.png", browser)
    command = f"mpfcad design {design.relative_to(MASKS.parent).as_posix()} --no-verify"
    return _entry(name, title, "searched, no verdict", command)


def _make_measured(name: str, options: argparse.Namespace, browser: str) -> str:
    """Measure the uniform film in a stack of LEDs, write the picture and return the entry."""
    folder = options.exports / name
    film = options.exports / "uniform-c60" / "film.stl"
    arguments = ["measure", str(film), "--stack", name, "--what", "contrast"]
    _call([*arguments, "--out", str(folder), "--effort", options.effort], (0,))
    picture(folder / "measure.html", options.out / f"{name}.png", browser)
    command = f"mpfcad measure exports/uniform-c60/film.stl --stack {name} --what contrast"
    return _entry(name, LEDS[name], "measured, no verdict", command)


def _call(arguments: list[str], expected: tuple[int, ...]) -> None:
    """Run a command of the program, or end with its exit code."""
    code = run_app(arguments)
    if code not in expected:
        sys.exit(code)


def _entries() -> dict[str, str]:
    """Return the entries of the page as it is, by the name of their picture."""
    page = DOCS / "gallery.md"
    parts = page.read_text("utf-8").split("\n## ")[1:] if page.is_file() else []
    return {
        found[1]: f"## {part.rstrip()}\n"
        for part in parts
        if (found := re.search(r"\(picture/(.*)\.png\)", part))
    }


def _write(entries: dict[str, str], effort: str) -> None:
    """Write the page as far as it is."""
    head = (
        "# Gallery\n\nJobs and measurements that matter, each with the first screen of its page.\n"
        f"`python docs/gallery.py` makes all of it; here with `--effort {effort}`.\n"
    )
    order = [name for name in (*RUNS, *DESIGNS, *LEDS) if name in entries]
    text = "\n".join([head, *(entries[name] for name in order)])
    (DOCS / "gallery.md").write_text(text, "utf-8")


def picture(page: Path, path: Path, browser: str) -> None:
    """Write a page's first screen as a small picture."""
    write_screenshot(page, path, browser, SIZE)
    with Image.open(path) as shown:
        _save_small(shown.convert("RGB"), path)


def plot_picture(page: Path, path: Path, browser: str, plot: str, part: str) -> None:
    """Write one plot of a page, without what stands around it, as a small picture."""
    hidden = f"""
        header, footer, main > #decision > :not(figure:has(#{plot})), details:not(:has(#{plot})),
        details > :not(figure:has(#{plot})), figcaption {{ display: none !important; }}
        details {{ border: 0; }}
        body, main {{ background: #fff; padding: 12px; margin: 0; border: 0; }}
    """
    write_screenshot(page, path, browser, SIZE, style=hidden, target=part)
    with Image.open(path) as shown:
        picture = shown.convert("RGB")
    blank = Image.new("RGB", picture.size, "white")
    _save_small(picture.crop(ImageChops.difference(picture, blank).getbbox()), path)


def _save_small(picture: Image.Image, path: Path) -> None:
    height = round(picture.height * SHOWN / picture.width)
    small = picture.resize((SHOWN, height), Image.Resampling.LANCZOS)
    small.quantize(_COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def _entry(name: str, title: str, result: str, command: str) -> str:
    return f"## {title}\n\n{result}.\n\n`{command}`\n\n![The page of {name}](picture/{name}.png)\n"


if __name__ == "__main__":
    sys.exit(main())
