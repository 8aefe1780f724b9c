"""What a run shows: progress on stderr, and its result on stdout."""

import sys
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad import compiling
from mpfcad.cli.character import print_json
from mpfcad.cli.likely import case_words, print_confidence
from mpfcad.cli.stream import one_line
from mpfcad.store.notice import listeners

if TYPE_CHECKING:
    from mpfcad.measure import TraceState


#: What takes so long to compile that one wonders, and about how long.
_COMPILED = {
    "trace_paths": ("the tracer", "20 s"),
    "trace_scores": ("the tracer with derivatives", "20 s"),
    "_trace_bin": ("the tracer of a film's BSDF", "15 s"),
    "trace_film": ("the search's rays through the film", "15 s"),
    "trace_world": ("the search's rays between two meetings with the film", "5 s"),
    "trace_meter": ("the search's rays from the meter", "5 s"),
}


#: Where paths over a cell of LEDs start, by the estimator's name.
_WAYS = {"forward": "from the LEDs", "backward": "from the meter"}
#: Columns of a terminal from which on there is room for a bar.
_WIDE = 60


class Terminal:
    """Progress on stderr: a live bar in a terminal, plain lines in a pipe or log file."""

    #: Seconds between two plain lines of one trace.
    interval = 10.0

    def __init__(self) -> None:
        self._live = sys.stderr.isatty()
        self._resources = ExitStack()
        self._start = time.monotonic()
        self._last_line = self._start
        self._stage = ""
        self._bar: Any = None
        self._task: Any = None
        self._trace_start: float | None = None

    def __enter__(self) -> "Terminal":
        compiling.watchers.append(self.compiling)
        self._resources.callback(compiling.watchers.remove, self.compiling)
        listeners.append(self.note)
        self._resources.callback(listeners.remove, self.note)
        if self._live:
            self._bar = self._resources.enter_context(_live_bar())
            self._task = self._bar.add_task("starting", total=None, note="")
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
        self._trace_start = None
        if self._live:
            self._bar.reset(self._task, total=None, description=text, note="")

    def _show_done(self) -> None:
        if self._stage and self._live:
            self._bar.console.print(f"[dim]{self._elapsed()}[/] {self._stage}", highlight=False)
        elif self._stage:
            self._show(self._stage)

    def note(self, text: str) -> None:
        """Show a line that stays."""
        if self._live:
            self._bar.console.print(text, highlight=False, markup=False)
        else:
            print(f"mpfcad: {one_line(text)}", file=sys.stderr, flush=True)

    def compiling(self, name: str | None) -> None:
        """Show that the function `name` is being compiled; None: that it has been."""
        text = ""
        if name in _COMPILED:
            what, time_needed = _COMPILED[name]
            text = f"compiling {what} for this processor, once: about {time_needed}"
        if self._live:
            self._bar.update(self._task, description=text or self._stage)
        elif text:
            self._show(text)

    def trace(self, state: "TraceState") -> None:
        """Show how far the trace is, in a pipe at most every `interval` seconds."""
        now = time.monotonic()
        if self._trace_start is None or state.paths <= state.start:
            self._trace_start = now
            if state.start:
                self.note(f"{self._stage}: goes on at {state.start / 1e6:.1f} M paths")
        if not self._live and now - self._last_line < self.interval:
            return
        note = trace_note(state, now - self._trace_start)
        if self._live:
            self._bar.update(self._task, completed=state.paths, total=state.expected, note=note)
        else:
            self._show(f"{self._stage}: {note}")

    def count(self, done: int, total: int, note: str) -> None:
        """Show how far a stage of counted steps is, in a pipe at most every `interval` seconds."""
        if self._live:
            self._bar.update(self._task, completed=done, total=total, note=note)
        elif time.monotonic() - self._last_line >= self.interval:
            self._show(f"{self._stage}: {note}")

    def _elapsed(self) -> str:
        return f"{time.monotonic() - self._start:6.1f} s"

    def _show(self, text: str) -> None:
        self._last_line = time.monotonic()
        print(f"{self._elapsed()} {text}", file=sys.stderr, flush=True)


def trace_note(state: "TraceState", seconds: float) -> str:
    """Return how far a trace is in words, with the time left at the rate of the last `seconds`."""
    parts = []
    done, left = state.paths - state.start, state.expected - state.paths
    if state.error == state.error:
        if left and done:
            rest = round(seconds * left / done)
            parts.append(f"{rest // 60}:{rest % 60:02d} left")
        parts.append(state.figure.format(state.error))
    parts.append(f"{state.paths / 1e6:.1f} of {state.expected / 1e6:.1f} M paths")
    return ", ".join(parts)


def _live_bar() -> Any:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, TextColumn
    from rich.table import Column
    from rich.text import Text

    class Stage(ProgressColumn):
        """The stage: of all columns the only one that a narrow terminal cuts."""

        def render(self, task: Any) -> Text:
            return Text(task.description, no_wrap=True, overflow="ellipsis")

    console = Console(stderr=True)
    columns: tuple[ProgressColumn, ...] = (Stage(), TextColumn("{task.fields[note]}", markup=False))
    if console.width >= _WIDE:
        bar = BarColumn(bar_width=8, table_column=Column(no_wrap=True))
        spinner = SpinnerColumn(table_column=Column(no_wrap=True))
        columns = (spinner, columns[0], bar, columns[1])
    return Progress(*columns, console=console, transient=True)


def print_gates(record: dict[str, Any]) -> None:
    """Print one line a gate, and what the printability is."""
    for gate in record["gates"]:
        print(gate_line(gate))
    if record.get("printability") is not None:
        print(f"printability: {record['printability']}")


def print_verdict(verification: dict[str, Any], folder: Path) -> None:
    """Print the verdict, one line a gate, and where the report is."""
    print_gates(verification)
    mean, relative = verification["mean_luminance_cd_m2"], verification["relative_luminance"]
    if mean is not None:
        print(
            f"mean normal luminance {mean['value']:.0f} cd/m2, {relative:.3f} of "
            f"{verification['baseline']['words']}"
        )
    note = ", phototool only" if verification.get("printability") == "phototool only" else ""
    likely = ""
    if "confidence" in verification:
        print_confidence(verification["confidence"])
        share = verification["confidence"]["probability"]["marginal"]["value"]
        likely = f" as stated; {share:.2f} likely in the real backlight"
    elif verification.get("process") is not None:
        likely = _print_words(verification)
    print(f"{verification['verdict']}{note}{likely}: {folder / 'report.html'}")


def _print_words(verification: dict[str, Any]) -> str:
    """Print how the film comes out as printed; return what is said of it beside the verdict."""
    printed = verification.get("printed")
    half = (verification.get("printing") or {}).get("curvature_half_width_per_mm")
    if printed is None:
        known = "not known" if half is None else f"± {half:.2g} /mm"
        return f" as designed; as printed not judged (C {known})"
    found, contrast = printed["probability"]["marginal"], printed["contrast"]
    low, high = contrast["ci95"]
    print(
        f"contrast as printed {contrast['value']:.4f} [{low:.4f}, {high:.4f}]: the process sets C "
        f"to ± {half or 0.0:.2g} /mm; at most {found['limit']:g}: {found['value']:.2f} "
        f"[{found['ci95'][0]:.2f}, {found['ci95'][1]:.2f}] likely"
    )
    return f" as designed; {found['value']:.2f} likely as printed"


def gate_line(gate: dict[str, Any]) -> str:
    """Return a gate as one line: outcome, name, value with interval, limit, and what is wrong."""
    value = "not measured" if gate["value"] is None else f"{gate['value']:.4g}"
    if gate["ci95"] is not None:
        low, high = gate["ci95"]
        value = f"{gate['value']:.4f} [{low:.4f}, {high:.4f}]"
    limit = f"{'≥' if gate.get('at_least') else '≤'} {gate['limit']:.6g}"
    if "marginal_limit" in gate:
        limit += f" (marginal ≤ {gate['marginal_limit']:.6g})"
    line = f"{gate['outcome']:<13}{gate['name']:<40}{value:<28}{limit}"
    return f"{line}  {gate['detail']}" if "detail" in gate else line


def print_trace(figures: dict[str, Any], *, as_json: bool) -> None:
    """Print the figures of a trace, as JSON or as a table."""
    if as_json:
        print_json(figures)
        return
    names = ["lamp_mura_contrast", "mean_luminance_cd_m2"]
    if "cell" in figures:
        across, along = (figures["cell"][f"{axis}_mm"] for axis in ("across", "along"))
        way, paths = figures["estimator"], f"{figures['paths'] / 1e6:.1f} M paths"
        print(f"cell {across:g} × {along:g} mm, {paths} {_WAYS[way['name']]}: {way['reason']}")
        names += ["luminance_above_led_cd_m2", "sigma_over_mean"]
    else:
        print("position_pitch  luminance_cd_m2  standard_error_cd_m2")
        for row in zip(*figures["luminance"].values(), strict=True):
            print(f"{row[0]:14.5f}  {row[1]:15.2f}  {row[2]:20.2f}")
    if "judged" in figures:
        print(figures["judged"]["words"])
    for name in names:
        low, high = figures[name]["ci95"]
        print(f"{name} {figures[name]['value']:.6g} [{low:.6g}, {high:.6g}]")
    for name, estimate in _estimates(figures.get("polarisation", {})):
        low, high = estimate["ci95"]
        print(f"{name} {estimate['value']:.6g} [{low:.6g}, {high:.6g}]")
    if "confidence" in figures:
        print_confidence(figures["confidence"])
    print(f"accelerator {figures['accelerator'] or 'none: no mesh'}")
    for note in figures["traced"]["notes"]:
        print(note)
    for table in figures["traced"]["tables"]:
        for note in table["notes"]:
            print(f"{table['file']}: {note}")


def _noise(estimate: dict[str, Any] | None) -> str:
    """Return the standard error of an estimate, the interval of one that has none."""
    if estimate is None:
        return ""
    if "standard_error" in estimate:
        return f"± {estimate['standard_error']:.2g}"
    low, high = estimate["ci95"]
    return f"[{low:.6g}, {high:.6g}]"


def print_measurement(record: dict[str, Any], folder: Path, *, as_json: bool) -> None:
    """Print the figures of a measurement with their standard errors, or the whole record."""
    if as_json:
        print_json(record)
        return
    figures = {name: value for name, value in record.items() if name != "confidence"}
    for name, estimate in _estimates(figures):
        value = "–" if estimate is None else f"{estimate['value']:.6g}"
        print(f"{name:<58}{value:>12} {_noise(estimate)}")
    if "confidence" in record:
        print_confidence(record["confidence"])
    print(folder / "measure.html")


def print_comparison(record: dict[str, Any], folder: Path, *, as_json: bool) -> None:
    """Print the summary of a comparison, a line a case, or the whole record."""
    if as_json:
        print_json(record)
        return
    is_cell = "cell" in record["cases"][0]["contrast"]
    over = (
        "luminance over bare prisms, light that leaves"
        if is_cell
        else ("luminance and efficiency over conventional")
    )
    print(f"case: contrast [95 %], normal {over}, sheets")
    for case in record["cases"]:
        contrast = case["contrast"]["lamp_mura_contrast"]
        low, high = contrast["ci95"]
        leaves = (
            case["contrast"]["energy"]["out"] if is_cell else case["relative_efficiency"]["value"]
        )
        print(
            f"{case['label']}: {contrast['value']:.4f} [{low:.4f}, {high:.4f}], "
            f"{case['relative_luminance']['value']:.3f}, {leaves:.3f}, {case['sheet_count']}"
            f"{case_words(case)}"
        )
    print(folder / "compare.html")


def _estimates(record: dict[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Return every (name, estimate) of a record; a width that is not there is None."""
    found: list[tuple[str, Any]] = []
    for key, value in record.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict) and {"value", "ci95"} <= value.keys():
            found.append((name, value))
        elif value is None and key.endswith("_deg"):
            found.append((name, None))
        elif isinstance(value, dict):
            found += _estimates(value, f"{name}.")
        elif (
            isinstance(value, list) and value and isinstance(value[0], dict) and "ci95" in value[0]
        ):
            found += [(f"{name}.{i}", entry) for i, entry in enumerate(value, 1)]
    return found
