"""What a run shows: progress on stderr, and its result on stdout."""

import json
import sys
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any


class Terminal:
    """Progress on stderr: a live line in a terminal, plain lines in a pipe or log file."""

    #: Seconds between two plain lines of one trace.
    interval = 10.0

    def __init__(self) -> None:
        self._live = sys.stderr.isatty()
        self._resources = ExitStack()
        self._start = time.monotonic()
        self._last_line = self._start
        self._stage = ""
        self._status: Any = None

    def __enter__(self) -> "Terminal":
        if self._live:
            from rich.console import Console

            console = Console(stderr=True)
            self._status = self._resources.enter_context(console.status("starting"))
        return self

    def __exit__(self, kind: object, *exception: object) -> None:
        if kind is None:
            self._show_done()
        self._resources.close()

    def stage(self, text: str) -> None:
        """Show that a new stage of the work begins, and that the last one is done.

        A pipe or log gets a stage's line when it is done, so that bad input leaves one line only.
        """
        self._show_done()
        self._stage = text
        if self._live:
            self._status.update(text)

    def _show_done(self) -> None:
        if self._stage and self._live:
            self._status.console.print(f"[dim]{self._elapsed()}[/] {self._stage}", highlight=False)
        elif self._stage:
            self._show(self._stage)

    def trace(self, paths: int, half_width: float) -> None:
        """Show how far the trace is, in a pipe at most every `interval` seconds."""
        self.progress(f"{paths / 1e6:.1f} million paths, contrast ± {half_width:.4f} (95 %)")

    def progress(self, text: str) -> None:
        """Show how far the stage is, in a pipe at most every `interval` seconds."""
        if self._live or time.monotonic() - self._last_line >= self.interval:
            self._show(f"{self._stage}: {text}")

    def _elapsed(self) -> str:
        return f"{time.monotonic() - self._start:6.1f} s"

    def _show(self, text: str) -> None:
        self._last_line = time.monotonic()
        if self._live:
            self._status.update(text)
        else:
            print(f"{self._elapsed()} {text}", file=sys.stderr, flush=True)


def print_verdict(verification: dict[str, Any], folder: Path) -> None:
    """Print the verdict, one line a gate, and where the report is."""
    for gate in verification["gates"]:
        interval, value = "", f"{gate['value']:.4g}"
        if gate["ci95"] is not None:
            low, high = gate["ci95"]
            interval, value = f" [{low:.4f}, {high:.4f}]", f"{gate['value']:.4f}"
        limit = f"{'≥' if gate.get('at_least') else '≤'} {gate['limit']:.6g}"
        if "marginal_limit" in gate:
            limit += f" (marginal ≤ {gate['marginal_limit']:.6g})"
        value += interval
        print(f"{gate['outcome']:<13}{gate['name']:<40}{value:<28}{limit}")
    mean = verification["mean_luminance_cd_m2"]["value"]
    relative = verification["relative_luminance"]
    print(f"mean normal luminance {mean:.0f} cd/m2, {relative:.3f} of the conventional stack")
    print(f"{verification['verdict']}: {folder / 'report.html'}")


def print_trace(figures: dict[str, Any], *, as_json: bool) -> None:
    """Print the figures of a trace, as JSON or as a table."""
    if as_json:
        print(json.dumps(figures, indent=1, ensure_ascii=False))
        return
    curve = figures["luminance"]
    print("position_pitch  luminance_cd_m2  standard_error_cd_m2")
    for row in zip(*curve.values(), strict=True):
        print(f"{row[0]:14.5f}  {row[1]:15.2f}  {row[2]:20.2f}")
    for name in ("lamp_mura_contrast", "mean_luminance_cd_m2"):
        low, high = figures[name]["ci95"]
        print(f"{name} {figures[name]['value']:.6g} [{low:.6g}, {high:.6g}]")
