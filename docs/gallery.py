"""Makes the gallery: ten jobs that matter, each with its report's first screen as a picture.

    python docs/gallery.py [--effort quick|standard|final] [--out docs/picture]

It needs a Chromium (`mpfcad doctor` says whether there is one) and writes the pictures and
docs/gallery.md.
"""

import argparse
import json
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
    options = parser.parse_args()
    browser = find_browser()
    options.out.mkdir(parents=True, exist_ok=True)
    lines = [
        "# Gallery", "",
        "Ten jobs and measurements, each with the first screen of its page.",
        f"`python docs/gallery.py` makes all of it; here with `--effort {options.effort}`.", "",
    ]  # fmt: skip
    for name, (title, job) in RUNS.items():
        folder = options.exports / name
        code = run_app(["run", str(job), "--out", str(folder), "--effort", options.effort])
        if code not in (0, 1):
            return code
        record = json.loads((folder / "verification.json").read_text("utf-8"))
        low, high = record["lamp_mura_contrast"]["ci95"]
        result = f"**{record['verdict']}**, contrast {low:.4f} … {high:.4f} (95 %)"
        command = f"mpfcad run {job.relative_to(MASKS.parent).as_posix()}"
        lines += _entry(name, title, result, command)
        _write(lines)
        picture(folder / "report.html", options.out / f"{name}.png", browser)
        if name == FEATURED:
            for file, (plot, part) in PLOTS.items():
                plot_picture(
                    folder / "report.html", options.out / f"{file}.png", browser, plot, part
                )
    film = options.exports / "uniform-c60" / "film.stl"
    for stack, title in LEDS.items():
        folder = options.exports / stack
        arguments = ["measure", str(film), "--stack", stack, "--what", "contrast"]
        code = run_app([*arguments, "--out", str(folder), "--effort", options.effort])
        if code != 0:
            return code
        command = f"mpfcad measure exports/uniform-c60/film.stl --stack {stack} --what contrast"
        lines += _entry(stack, title, "measured, no verdict", command)
        picture(folder / "measure.html", options.out / f"{stack}.png", browser)
        _write(lines)
    return 0


def _write(lines: list[str]) -> None:
    """Write the page as far as it is."""
    (DOCS / "gallery.md").write_text("\n".join(lines), "utf-8")


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


def _entry(name: str, title: str, result: str, command: str) -> list[str]:
    return [
        f"## {title}", "", f"{result}.", "", f"`{command}`", "",
        f"![The page of {name}](picture/{name}.png)", "",
    ]  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
