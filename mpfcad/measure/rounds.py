"""Traces in rounds until a figure is known well enough, and goes on where it was interrupted."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mpfcad.backlight.stack import Stack
from mpfcad.errors import TraceError
from mpfcad.measure.cell.estimator import Estimator
from mpfcad.measure.checkpoint import AnyTally, Checkpoints, Sums
from mpfcad.measure.contrast.blur import is_blurred
from mpfcad.measure.meter import Spot, meter_spot
from mpfcad.store import array_hash, value_hash, work_key

if TYPE_CHECKING:
    from mpfcad.backlight.lower import Mesh
    from mpfcad.optics.base.recorder import Tally
    from mpfcad.optics.element import Element
    from mpfcad.optics.scene import Scene
    from mpfcad.optics.source import Source
    from mpfcad.optics.spectral.engine import Spectral

#: A first round has at least so many paths.
LEAST_PATHS = 270_000
#: Largest share of the light that may end nowhere.
LOST_LIMIT = 1e-6


@dataclass(eq=False)
class Trail:
    """What a figure was after each round, so that a reader sees how it settled.

    Attributes
    ----------
    figure
        value and ends of its interval of a tally
    rows
        (paths, value, low, high) after each round
    """

    figure: Callable[[Any], tuple[float, float, float]]
    rows: list[tuple[float, ...]] = field(default_factory=list)

    def note(self, tally: Sums) -> None:
        """Add the figure of a round that is not noted yet."""
        if not self.rows or self.rows[-1][0] < tally.total_paths:
            self.rows.append((float(tally.total_paths), *self.figure(tally)))


class TraceState(NamedTuple):
    """How far a trace is.

    Attributes
    ----------
    paths, expected
        paths traced; paths that the whole trace is expected to take, by error ∝ 1/√paths
    error, goal
        of the figure that ends the trace, after the last whole round, and where it ends; nan before
    figure
        what that error is of, in words with a place for the number
    start
        paths that an interrupted trace had left
    """

    paths: int
    expected: int
    error: float
    goal: float
    figure: str
    start: int = 0


@dataclass(frozen=True)
class TraceRun:
    """How to trace: seed, threads, where checkpoints lie, who watches, which way under LEDs.

    `progress` is called after each block of paths; figures do not depend on it, on `threads` or on
    `checkpoints`. Lost paths are refused, unless a gate judges them (`judged`).
    """

    seed: int = 1
    threads: int = 1
    path_limit: int = 100_000_000
    checkpoints: Checkpoints = field(default_factory=Checkpoints)
    progress: Callable[[TraceState], None] | None = None
    judged: bool = False
    estimator: Estimator = Estimator.auto


@dataclass(frozen=True, eq=False)
class Lit:
    """A film mesh in its stack, ready to trace.

    Attributes
    ----------
    stack
        the backlight
    elements, scene
        from the bottom up, and lowered for the kernels
    case
        what the scene depends on, in plain values
    spot
        of the luminance meter, whole grooves of the film
    notes
        a line of what was read of the film's file
    spectral
        the scene in bands, where the stack states them
    """

    stack: Stack
    elements: "list[Element]"
    scene: "Scene"
    case: dict[str, Any]
    name: str
    spot: Spot
    notes: list[str] = field(default_factory=list)
    spectral: "Spectral | None" = None

    @property
    def accelerator(self) -> str:
        """How the films are traced."""
        return self.scene.accelerators

    @property
    def is_cell(self) -> bool:
        """Whether what lights it repeats along y too: LEDs."""
        return self.stack.period.along > 0

    @property
    def is_finite(self) -> bool:
        """Whether the panel has edges; else everything repeats sideways without end."""
        return self.stack.extent == "panel"

    @property
    def is_blurred(self) -> bool:
        """Whether sheets spread the light of tubes so far that the luminance has no kinks."""
        return is_blurred(self.elements, self.stack.period.across)


def light_film(
    stack: Stack,
    mesh_path: Path | None,
    offset: float = 0.0,
    mesh: "Mesh | None" = None,
    read: "Callable[[Path], Mesh] | None" = None,
) -> Lit:
    """Return a film mesh, read from disk, in a stack; `offset` [mm]: left edge from a lamp's axis.

    `mesh` is what was read of the file already, if it was; `read` reads the other films' files,
    those of one wavelength. `mesh_path` is None for a stack without film, that of a BSDF table in
    its place.

    Raises
    ------
    InputError
        when the mesh cannot be read or traced.
    """
    from mpfcad.backlight.band_scene import lower_bands
    from mpfcad.backlight.lower import lower_stack, read_film
    from mpfcad.optics.scene import build_scene
    from mpfcad.optics.solid.mesh import FilmMesh

    if mesh is None and mesh_path is not None:
        mesh = read_film(mesh_path)
    spot = meter_spot(stack, mesh if isinstance(mesh, FilmMesh) else None)
    elements = lower_stack(stack, mesh, offset, read or read_film)
    scene = build_scene(elements, polarised=stack.polarised)
    case = {
        "mesh": mesh_path and hashlib.sha256(Path(mesh_path).read_bytes()).hexdigest(),
        "offset": offset,
        "stack": value_hash(_by_value(stack)),
        "scene": array_hash(scene),
    }
    notes = [] if mesh is None else [mesh.note]
    if spot.is_rounded:
        notes.append(spot.note)
    spectral = lower_bands(stack, mesh, offset, elements)
    return Lit(stack, elements, scene, case, str(mesh_path or stack.name), spot, notes, spectral)


def _by_value(stack: Stack) -> list[Any]:
    """Return a stack with the files that it needs by their content, not by where they lie."""
    own = {name: replace(layer, file=None) for name, layer in stack.own.items()}
    # A folder has its place for the film without resin whether or not it holds one.
    prism = stack.prism if stack.prism is not None and stack.prism.is_file() else None
    return [replace(stack, own=own, prism=None), stack.files(), prism]


def trace_rounds(
    lit: Lit,
    source: "Source",
    run: TraceRun,
    error_of: "Callable[[Tally], float]",
    goal: float,
    figure: str,
    *,
    least_blocks: int = 2,
    trail: Trail | None = None,
    begun: "Tally | None" = None,
) -> "Tally":
    """Return the tally of enough rounds that `error_of` it is at most `goal`, or the path limit.

    `trail` gets a figure's value after each round, those before an interruption among them. `begun`
    is this trace's first round where it is done already.

    Rounds grow with what is done, so that few errors are computed and little is overshot; which
    they are depends on nothing but the number of points.

    Raises
    ------
    TraceError
        when more than 1e-6 of the light is lost, and no gate judges it.
    """
    from mpfcad.optics.base.recorder import Tally
    from mpfcad.optics.engine import BLOCK, flow_count

    points = len(source.position)
    block = points * BLOCK

    def more(done: int) -> int:
        grown = max(-(-LEAST_PATHS // block), done // 4, 2)
        return grown if done else max(grown, least_blocks)

    def add(tally: "Tally", blocks: range, after: "Callable[[], None] | None") -> "Tally":
        return tally + trace_lit(
            lit, source, len(blocks), seed=run.seed, first=blocks.start, threads=run.threads,
            after_block=after,
        )  # fmt: skip

    begun = begun or Tally.empty(points, flow_count(lit.scene, points))
    return in_rounds(
        lit, run, {"source": source}, begun, add, error_of, goal, figure, block=block, more=more,
        trail=trail,
    )  # fmt: skip


def in_rounds(
    lit: Lit,
    run: TraceRun,
    meter: dict[str, Any],
    begun: AnyTally,
    add: Callable[[AnyTally, range, Callable[[], None] | None], AnyTally],
    error_of: Callable[[AnyTally], float],
    goal: float,
    figure: str,
    *,
    block: int,
    more: Callable[[int], int],
    trail: Trail | None = None,
) -> AnyTally:
    """Return the tally of enough rounds that `error_of` it is at most `goal`, or the path limit.

    A round is kept when it is done, under the key of all that the tally depends on; a trace that
    was interrupted goes on from its last one.

    Parameters
    ----------
    meter
        what of the trace is not of the scene or the run, in plain values
    begun
        the tally to begin with: of no paths, or of the first round
    add
        traces numbered blocks into a tally; calls its last argument, if any, after each
    block
        paths of one
    more
        how many blocks a round has after so many

    Raises
    ------
    TraceError
        when more than 1e-6 of the light is lost, and no gate judges it.
    """
    asked = {"figure": figure, "seed": run.seed, "goal": goal, "limit": run.path_limit}
    inputs = {**lit.case, **meter, **asked}
    case = work_key("trace", inputs)
    error = float("nan")
    trail = trail or Trail(lambda tally: (error, error, error))
    left = run.checkpoints.read(case, type(begun))
    tally, trail.rows[:] = left or (begun, [])
    start = tally.total_paths if left else 0
    while True:
        if tally.blocks:
            error = error_of(tally)
            trail.note(tally)
            if error <= goal or tally.total_paths >= run.path_limit:
                break
        state = TraceState(tally.total_paths, run.path_limit, error, goal, figure, start)
        after = Watch(run.progress, state, block).block if run.progress else None
        tally = add(tally, range(tally.blocks, tally.blocks + more(tally.blocks)), after)
        run.checkpoints.write(case, tally, trail.rows)
    if run.progress:
        paths = tally.total_paths
        run.progress(TraceState(paths, paths, error, goal, figure, start))
    _refuse_lost(lit, run, tally)
    return tally


def _refuse_lost(lit: Lit, run: TraceRun, tally: Any) -> None:
    from mpfcad.optics.base.recorder import FLOWS

    lost = tally.flow[FLOWS.index("lost")] / tally.total_paths
    if lost > LOST_LIMIT and not run.judged:
        raise TraceError(
            f"{lit.name}: {lost:.2e} of the light was lost: expected at most {LOST_LIMIT:g}"
        )


def trace_lit(lit: Lit, source: "Source", blocks: int, **how: Any) -> "Tally":
    """Return the tally of blocks of paths, in bands where a meter looks at a stack that has them.

    Light that starts elsewhere is traced at the stack's one wavelength. `how` as of `engine.trace`.
    """
    from mpfcad.optics.engine import trace
    from mpfcad.optics.source import EYE
    from mpfcad.optics.spectral.engine import trace_luminance

    if lit.spectral is not None and source.kind == EYE:
        return trace_luminance(lit.spectral, source, blocks, **how)
    return trace(lit.scene, source, blocks, **how)


def relative_error(tally: "Tally") -> float:
    """Return the points' standard error, root mean square, over their mean luminance."""
    return float(np.sqrt(np.mean(tally.radiance_error**2)) / np.mean(tally.radiance))


class Watch:
    """Tells a watcher of each block within a round."""

    def __init__(
        self, progress: Callable[[TraceState], None] | None, state: TraceState, block: int
    ) -> None:
        self._progress, self._block = progress, block
        expected = state.expected
        if state.paths and state.goal > 0:  # without a goal it goes on to its limit
            expected = min(expected, round(state.paths * (state.error / state.goal) ** 2))
        self._state = state._replace(expected=expected)

    def block(self) -> None:
        """Count one more block."""
        paths = self._state.paths + self._block
        self._state = self._state._replace(paths=paths, expected=max(paths, self._state.expected))
        if self._progress is not None:
            self._progress(self._state)
