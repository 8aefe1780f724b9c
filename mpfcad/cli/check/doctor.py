"""`mpfcad doctor`: what is installed, compiled and kept, and how fast this machine traces."""

import os
import platform
import sys
from typing import Annotated, Any

import typer

from mpfcad.cli.character import print_json
from mpfcad.cli.option import Json


def command(
    json: Json = False,
    speed: Annotated[
        bool, typer.Option("--speed/--no-speed", help="Trace for a few seconds and say how fast.")
    ] = True,
) -> int:
    """Say what is installed, compiled and kept, and how fast this machine traces."""
    measured: dict[str, Any] = {}
    if speed:
        from mpfcad.cli.terminal import Terminal
        from mpfcad.pipeline.speed import trace_speed

        with Terminal() as terminal:
            terminal.stage("tracing a plain prism film")
            ready, rate = trace_speed()
        measured = {"tracer_ready_s": round(ready, 1), "million_paths_per_s": round(rate, 3)}
    facts = _facts() | measured
    if json:
        print_json(facts)
        return 0
    for name, value in facts.items():
        words = (
            ", ".join(f"{k} {v}" for k, v in value.items()) if isinstance(value, dict) else value
        )
        print(f"{name:<22}{words}")
    return 0


def _facts() -> dict[str, Any]:
    from importlib.util import find_spec

    from mpfcad import __version__
    from mpfcad.pipeline.effort import available_threads
    from mpfcad.store import cache_folder, versions
    from mpfcad.store.entry import list_entries
    from mpfcad.store.kernel import kernel_folder

    kernels = [e for e in list_entries(kernel_folder()) if e.kind == "kernel"]
    kept = [e for e in list_entries(cache_folder()) if e.kind != "kernel"]
    extras = ("SurfaceTopography", "distributed")
    return {
        "mpfcad": __version__,
        "python": f"{platform.python_version()} ({sys.executable})",
        "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
        "cores": f"{available_threads()} usable of {os.cpu_count()}",
        "libraries": versions(),
        "extras": {name: "yes" if find_spec(name) else "no" for name in extras},
        "browser_for_pdf": _browser(),
        "kernels": f"{len([e for e in kernels if e.state == 'kept'])} compiled of this version, in "
        f"{kernel_folder()}",
        "kept_work": f"{len(kept)} files, {sum(e.size for e in kept) / 1e6:.1f} MB, in "
        f"{cache_folder()}",
        "terminal": f"stdout {sys.stdout.encoding}, stderr {sys.stderr.encoding}",
    }


def _browser() -> str:
    from mpfcad.errors import InputError
    from mpfcad.report.browser import find_browser

    try:
        return find_browser()
    except InputError:
        return "none: mpfcad run --pdf needs a Chromium"
