"""The least thickness that serves: the model proposes one, full searches there decide.

A thickness serves when a traced map's contrast has its 95 % interval below the job's acceptance
limit. Between thicknesses already searched the model, with what the traces have said of it so far,
proposes the next; the search ends when one serves and the one below it does not.
"""

from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.design import (
    Correction,
    Goal,
    Iteration,
    Prediction,
    Response,
    correction_of,
    find_optimum,
    predict,
)
from mpfcad.job.design import Design
from mpfcad.pipeline.design.reach import contrast_bound
from mpfcad.pipeline.design.record import describe_iteration
from mpfcad.pipeline.design.work import DesignWork
from mpfcad.pipeline.point.thickness_limit import (
    FAILS,
    SERVES,
    describe_limit,
    outcome,
    spread_lamps,
)
from mpfcad.pipeline.point.trace import POINT, Point, conventional_point, trace_point
from mpfcad.pipeline.progress import Progress
from mpfcad.store import Store

#: What is tried where the least thickness of the range does not serve: more of each sheet's
#: scattering, and more lamps.
_SIGMA_STEP, _LAMP_STEPS = 0.15, (2, 4)


class ThicknessSearch:
    """A design searched over its range of thickness."""

    def __init__(self, design: Design, file: Path, threads: int, progress: Progress) -> None:
        self.design, self.file = design, file
        self.threads, self.progress = threads, progress
        assert design.thickness is not None  # who calls has looked
        self.table = design.thickness
        self.values = self.table.values()
        self.limit = design.gates.contrast_marginal
        self.predicted: dict[float, Prediction] = {}
        self.traced: dict[float, list[Iteration]] = {}
        self._series: dict[float, np.ndarray] = {}
        self._works: dict[float, DesignWork] = {}
        self._correction = Correction.none()

    def work(self, thickness: float) -> DesignWork:
        """Return the design at one thickness [mm]; its traces are kept apart."""
        if thickness not in self._works:
            self._works[thickness] = DesignWork(
                self.design.at_thickness(thickness),
                self.file,
                self.threads,
                _Named(self.progress, f"{thickness:g} mm: "),
            )
        return self._works[thickness]

    def search(self) -> float | None:
        """Return the least thickness [mm] that serves, or None when none does."""
        for ends in (0, len(self.values) - 1):
            self._predict(self.values[ends])
        fails, serves = -1, len(self.values)
        while serves - fails > 1:
            number = self._proposal(fails, serves)
            if self._serves(self.values[number]):
                serves = number
            else:
                fails = number
        return None if serves == len(self.values) else self.values[serves]

    def _proposal(self, fails: int, serves: int) -> int:
        """Return the least thickness between both that serves by the model, else the next one."""
        low, high = fails, serves
        while high - low > 1:
            middle = (low + high) // 2
            if self._predict(self.values[middle]).contrast <= self.limit:
                high = middle
            else:
                low = middle
        return min(high, serves - 1)

    def _predict(self, thickness: float) -> Prediction:
        """Return what the corrected model says of the best map at a thickness."""
        work = self.work(thickness)
        if thickness not in self._series:
            self._series[thickness] = best_series(work, work.response)
        shift = work.goal.registration / work.pitch
        self.predicted[thickness] = predict(
            self._series[thickness], work.response, self._correction, shift
        )
        return self.predicted[thickness]

    def _serves(self, thickness: float) -> bool:
        """Return whether a map that the search finds at a thickness serves, by its trace."""
        work = self.work(thickness)
        self.traced[thickness] = work.search_maps(self.limit)
        shift = work.goal.registration / work.pitch
        self._correction = correction_of(self.traced[thickness], work.response, shift)
        return self._outcome(thickness) == SERVES

    def best(self, thickness: float) -> Iteration:
        """Return the best traced map of a thickness."""
        return self.work(thickness).best(self.traced[thickness])

    def _outcome(self, thickness: float) -> str:
        traced = self.best(thickness).worst
        return outcome({"ci95": [traced.contrast_low, traced.contrast_high]}, self.limit)

    def describe(self, least: float | None) -> dict[str, Any]:
        """Return what was found of every thickness, in outside names."""
        for thickness in self._series:
            self._predict(thickness)
        points = []
        for thickness in sorted(self.predicted):
            found = self.predicted[thickness]
            traced = None
            if thickness in self.traced:
                whole = describe_iteration(self.best(thickness))
                keys = ("label", "lamp_mura_contrast", "mean_luminance_cd_m2", "curvature_per_mm")
                traced = {key: whole[key] for key in keys}
                traced["outcome"] = self._outcome(thickness)
                traced["paths"] = sum(one.paths for one in self.traced[thickness])
            model = {
                "lamp_mura_contrast": found.contrast,
                "mean_luminance_cd_m2": found.mean,
            }
            points.append({"thickness_mm": thickness, "model": model, "traced": traced})
        return {
            "min_mm": self.table.min_mm,
            "max_mm": self.table.max_mm,
            "step_mm": self.table.step_mm,
            "contrast_limit": self.limit,
            "least_mm": least,
            "points": points,
            "limit": self._limit(points),
            "bounds": self._bounds(least),
            "remedies": [] if least == self.values[0] else self._remedies(self.values[0]),
        }

    def _limit(self, points: list[dict[str, Any]]) -> dict[str, Any]:
        """Return which thicknesses serve, and where the light equals the conventional stack's.

        Luminances as traced, elsewhere by the corrected model.
        """
        traced = [point for point in points if point["traced"]]
        found = describe_limit(
            [point["thickness_mm"] for point in traced],
            [point["traced"]["lamp_mura_contrast"] for point in traced],
            [point["traced"]["mean_luminance_cd_m2"]["value"] for point in traced],
            self._conventional(),
            self.limit,
        )
        light = describe_limit(
            [point["thickness_mm"] for point in points],
            [{"ci95": [0.0, 0.0]}] * len(points),
            [
                point["traced"]["mean_luminance_cd_m2"]["value"]
                if point["traced"]
                else point["model"]["mean_luminance_cd_m2"]
                for point in points
            ],
            found["conventional_luminance_cd_m2"],
            self.limit,
        )
        keys = ("equal_luminance_mm", "relative_luminance")
        profile = self.design.film.profile
        return {"profile": profile, **found, **{key: light[key] for key in keys}}

    def _bounds(self, least: float | None) -> list[dict[str, Any]]:
        """Return what no map goes below at the smallest thickness and where a traced one fails."""
        failed = {t for t in self.traced if self._outcome(t) == FAILS}
        if least != self.values[0]:
            failed.add(self.values[0])
        return [
            {
                "thickness_mm": t,
                "contrast_bound": contrast_bound(self.work(t), self.traced.get(t, [])),
                "corrected": t in self.traced,
            }
            for t in sorted(failed)
        ]

    def _conventional(self) -> float:
        """Return the conventional stack's mean luminance [cd/m²], traced once."""
        paths = round(self.design.search.paths_million * 1e6)
        like = Point({}, {}, str(self.file), 0.0, paths)
        point = conventional_point(like, self.design.seed)
        store, key = Store.open(self.progress.note), point.key()
        kept = store.read_json(POINT, key)
        if kept is None:
            self.progress.stage("tracing the conventional stack")
            kept = store.keep_json(POINT, key, trace_point(point, self.threads))
        return kept["mean_luminance_cd_m2"]["value"]

    def _remedies(self, thickness: float) -> list[dict[str, Any]]:
        """Return what the model says of a thickness that does not serve, with more of something."""
        stack = self.work(thickness).stack
        changes: list[dict[str, float]] = [{}]
        for layer in stack.layers:
            if stack.kind_of(layer) == "sheet":
                name = f"{layer}.sigma" if layer in stack.own else f"{layer}_sigma"
                changes.append({name: round(stack[name] + _SIGMA_STEP, 6)})
        for more in _LAMP_STEPS:
            changes.append(spread_lamps(stack.panel_width, stack.source.count + more))
        return [self._remedy(thickness, change) for change in changes]

    def _remedy(self, thickness: float, change: dict[str, float]) -> dict[str, Any]:
        words = ", ".join(f"{name} = {value:g}" for name, value in change.items())
        design = self.design.at_thickness(thickness, change)
        named = _Named(self.progress, f"{thickness:g} mm, {words or 'as it is'}: ")
        work = DesignWork(design, self.file, self.threads, named)
        found = predict(best_series(work, work.response), work.response, Correction.none())
        return {
            "thickness_mm": thickness,
            "override": change,
            "lamp_mura_contrast": found.contrast,
            "mean_luminance_cd_m2": found.mean,
        }


def best_series(work: DesignWork, response: Response) -> np.ndarray:
    """Return the best map's series [1/mm] by the uncorrected model, from the range's middle."""
    constraint = work.constraint
    middle = (constraint.curvature_min + constraint.curvature_max) / 2
    start = np.append(middle, np.zeros(constraint.harmonics))
    goal = Goal(registration=work.goal.registration)
    return find_optimum(start, response, Correction.none(), constraint, goal, work.pitch)


class _Named:
    """Progress with words before each stage's."""

    def __init__(self, progress: Progress, prefix: str) -> None:
        self._progress, self._prefix = progress, prefix
        self.trace, self.note = progress.trace, progress.note

    def stage(self, text: str) -> None:
        """Show that a new stage begins."""
        self._progress.stage(self._prefix + text)
