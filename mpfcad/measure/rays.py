"""Rays of a backlight's light: those that leave the screen, or that come up to the film."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError, TraceError
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.rounds import LOST_LIMIT, Lit, TraceRun, TraceState

if TYPE_CHECKING:
    from mpfcad.optics.forward.passing import Passing

#: Where rays are taken: as they leave the screen, or as they come up to the job's film.
At = Literal["screen", "film"]
PLACES: tuple[At, ...] = ("screen", "film")
#: Blocks of one round: what memory holds.
_ROUND = 64
#: Rays a path below which too little light arrives, told after so many blocks.
_LEAST, _TOLD = 1e-4, 32


@dataclass(frozen=True)
class RayResult:
    """What was collected.

    Attributes
    ----------
    rays, paths
        rays handed on; paths from the lamps that they are of
    flux
        [lm] of the whole panel that the rays stand for
    unit
        [lm] of a ray of weight 1
    """

    rays: int
    paths: int
    flux: Estimate
    unit: float


def gate_of(lit: Lit, at: At) -> int:
    """Return the number of the element that rays come up to; of all elements for the screen.

    Raises
    ------
    InputError
        when the stack has no film of the job's, or no air under it, or its light is polarised or
        in bands.
    """
    from mpfcad.optics.element import Slab

    if lit.stack.polarised:
        raise InputError(
            f"{lit.stack.name}: light.polarised: ray files hold no polarisation: expected "
            "light that is not polarised"
        )
    if lit.stack.bands is not None:
        raise InputError(
            f"{lit.stack.name}: light.bands: ray files hold one wavelength: expected no bands"
        )
    if at == "screen":
        return len(lit.elements)
    stack = lit.stack
    slot = [layer for layer in stack.layers if stack.is_slot(layer)]
    if not slot:
        raise InputError(f"{stack.name}: no film in the stack: expected rays at the screen")
    if slot[0] == "bonded_film":
        raise InputError(f"{stack.name}: film bonded on a plate: expected air under it")
    name = slot[0].replace("_", " ")
    number = next(
        i for i, one in enumerate(lit.elements)
        if one.name == name
    )  # fmt: skip
    below = lit.elements[number - 1]
    while isinstance(below, Slab) and below.bonded:
        number -= 1
        below = lit.elements[number - 1]
    return number


def collect_rays(
    lit: Lit, at: At, count: int, run: TraceRun, keep: Callable[[NDArray[np.float32]], None]
) -> RayResult:
    """Hand `count` rays on to `keep`, (n, 7) float32 at a time, in the order of their paths.

    A ray is place [mm] about the panel's middle, direction and weight; z = 0 is the surface that it
    leaves or comes up to. `RayResult.paths` are the paths before that of the ray after the last, so
    flux and distribution have no bias of where the rays end.

    Raises
    ------
    InputError
        when hardly any light arrives.
    TraceError
        when paths are lost.
    """
    from mpfcad.optics.forward.passing import BLOCK, passing_rays

    gate, taken = gate_of(lit, at), _Taken(_Tiling.of(lit), count, run.seed)
    while not taken.is_whole:
        first, wanted = taken.blocks, 1
        if taken.rays:
            wanted += int((count - taken.rays) * taken.paths / taken.rays) // BLOCK
        blocks = range(first, first + min(_ROUND, wanted))
        for part in passing_rays(lit.scene, gate, blocks, seed=run.seed, threads=run.threads):
            if not taken.is_whole:
                keep(taken.take(part))
        if run.progress:
            expected = max(taken.paths, round(taken.paths * count / max(taken.rays, 1)))
            run.progress(TraceState(taken.paths, expected, np.nan, np.nan, ""))
        if taken.blocks >= _TOLD and taken.rays < _LEAST * taken.paths:
            raise InputError(
                f"{lit.stack.name}: {taken.rays} rays of {taken.paths} paths from the lamps come "
                f"to the {at}: expected light there"
            )
    lost = taken.lost / (taken.blocks * BLOCK)
    if lost > LOST_LIMIT:
        raise TraceError(f"{lit.name}: {lost:.2e} of the paths were lost")
    emitted, share = lit.stack.source.flux, taken.sums.share(taken.paths)
    flux = Estimate(*(emitted * value for value in vars(share).values()))
    return RayResult(taken.rays, taken.paths, flux, emitted / taken.paths)


class _Taken:
    """The rays that were taken of one block after the other, and what is known of them."""

    def __init__(self, tiling: "_Tiling", count: int, seed: int) -> None:
        self.tiling, self.count, self.seed = tiling, count, seed
        self.sums = _NetSums()
        self.rays = self.paths = self.blocks = 0
        self.lost = 0.0
        self.is_whole = False

    def take(self, part: "Passing") -> NDArray[np.float32]:
        """Return the rays (n, 7) of the next block, as many as are still wanted."""
        from mpfcad.optics.base.recorder import FLOW_LOST
        from mpfcad.optics.caught import DX, WEIGHT
        from mpfcad.optics.forward.passing import BLOCK

        left, paths = self.count - self.rays, BLOCK
        self.is_whole = len(part.ray) > left
        if self.is_whole:
            # Where the last ones of a path's rays stay out, the path counts all the same.
            paths = int(part.path[left]) + int(left > 0 and part.path[left] == part.path[left - 1])
        ray, path = part.ray[:left], part.path[:left]
        table = np.zeros((len(ray), 7), np.float32)
        table[:, :2] = self.tiling.place(ray[:, :2], self.seed, self.blocks)
        table[:, 3:6] = ray[:, DX : DX + 3]
        table[:, 6] = ray[:, WEIGHT]
        self.sums.add(path, ray[:, WEIGHT], paths)
        self.rays, self.paths, self.blocks = (
            self.rays + len(ray),
            self.paths + paths,
            self.blocks + 1,
        )
        self.lost += float(part.flow[FLOW_LOST])
        return table


class _NetSums:
    """Sums of the weights of the paths of each net, which are independent replicates."""

    def __init__(self) -> None:
        self.net: list[NDArray[np.float64]] = []
        self.rest = np.zeros(0)

    def add(self, path: NDArray[np.int64], weight: NDArray[np.float64], paths: int) -> None:
        """Add the rays of `paths` paths."""
        from mpfcad.optics.base.net import NET

        each = np.bincount(path, weight, minlength=paths)[:paths].astype(np.float64)
        whole = paths // NET * NET
        self.net.append(each[:whole].reshape(-1, NET).sum(axis=1))
        self.rest = each[whole:]

    def share(self, paths: int) -> Estimate:
        """Return the weight that arrives of a path's, with the error of whole nets' spread."""
        from mpfcad.optics.base.net import NET

        net = np.concatenate(self.net)
        mean = float((net.sum() + self.rest.sum()) / paths)
        if len(net) < 2:  # a handful of rays: the paths' own spread, which is too large
            spread = float(np.std(self.rest, ddof=1)) if len(self.rest) > 1 else mean
            return Estimate.student(mean, spread / np.sqrt(paths), max(paths - 1, 1))
        error = float(np.std(net, ddof=1) / NET * np.sqrt(NET / paths))
        return Estimate.student(mean, error, len(net) - 1)


@dataclass(frozen=True)
class _Tiling:
    """How what repeats without end is laid over the panel.

    Attributes
    ----------
    period, copies
        size [mm] of what repeats across and along; how often it stands on the panel
    shift
        [mm] from the scene's x = y = 0 to the panel's middle, where nothing repeats
    """

    period: NDArray[np.float64]
    copies: NDArray[np.float64]
    shift: NDArray[np.float64]

    @classmethod
    def of(cls, lit: Lit) -> "_Tiling":
        """Return that of a stack: none on a finite panel."""
        stack = lit.stack
        half = np.array([stack.panel_width, stack.panel_length]) / 2
        if lit.is_finite:
            return cls(np.ones(2), np.zeros(2), half - np.array(stack.origin))
        period = np.array([stack.period.across, stack.period.along or lit.scene.length])
        copies = np.maximum(np.round(np.array(stack.source.lit_size) / period), 1.0)
        return cls(period, copies, np.zeros(2))

    def place(self, xy: NDArray[np.float64], seed: int, block: int) -> NDArray[np.float64]:
        """Return places (n, 2) [mm] of a block's rays about the panel's middle.

        Each ray of what repeats is put into one of the copies, by chance.
        """
        if not self.copies.all():
            return xy - self.shift
        inner = xy / self.period + 0.5
        random = np.random.Generator(np.random.Philox(key=[seed, block])).random(xy.shape)
        placed = np.floor(random * self.copies) + inner - np.floor(inner)
        return np.asarray((placed - self.copies / 2) * self.period)
