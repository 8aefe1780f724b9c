"""`goal.aim = "confidence"`: the map most likely within the limit, beside the nominal one."""

from typing import Any, NamedTuple

import numpy as np

from mpfcad.confidence import STEP
from mpfcad.design import (
    FilmState,
    Iteration,
    Scenarios,
    correction_of,
    drawn_contrasts,
    find_likely,
    series_rows,
)
from mpfcad.pipeline.confidence.covariance import with_covariance
from mpfcad.pipeline.confidence.find import Asked, describe_likely
from mpfcad.pipeline.confidence.variant import SHIFT
from mpfcad.pipeline.design.judged import DRAWN, Judged, draws_of, judge
from mpfcad.pipeline.design.work import DesignWork

#: Draws of the programme.
_DRAWS = 600
#: Maps traced for the confidence; each corrects the model for the next.
_ROUNDS = 2


class Likeliest(NamedTuple):
    """What the search found.

    Attributes
    ----------
    chosen
        the map that is written
    traced
        maps traced on the way, the nominal search's not among them
    record
        both designs beside each other, in outside names
    """

    chosen: Iteration
    traced: list[Iteration]
    record: dict[str, Any]


def search_likely(work: DesignWork, done: list[Iteration]) -> Likeliest:
    """Return the map most likely within the limit, after the nominal search's maps `done`.

    The limit is `gates.contrast_marginal`. Of it and the best of `done`, the one that traces say is
    likelier is chosen.
    """
    asked = Asked.of(with_covariance(work.job, work.file))
    nominal = judge(work, work.best(done), asked)
    scenarios = scenarios_of(work, nominal, asked)
    found: list[Iteration] = []
    start = drawn_contrasts(
        np.array(nominal.one.series), work.response, correction_of([nominal.one], work.response),
        scenarios,
    )  # fmt: skip
    predicted = [scenarios.share(start)]
    for number in range(_ROUNDS):
        known = [nominal.one, *found]
        correction = correction_of(known, work.response)
        label = f"confidence {number + 1}"
        work.progress.stage("searching the map most likely within the limit")
        series = find_likely(
            np.array(known[-1].series), work.response, correction, work.constraint, scenarios,
            work.pitch,
        )  # fmt: skip
        contrast = drawn_contrasts(series, work.response, correction, scenarios)
        predicted.append(scenarios.share(contrast))
        rows = work.finished(series_rows(series)[1])
        traced = work.trace(rows, label, len(done) + number)
        numbers = tuple(map(float, rows)), tuple(map(float, series))
        found.append(Iteration(label, *numbers, None, None, traced))
    robust = judge(work, found[-1], asked)
    both = {"nominal": nominal, "confidence": robust}
    described = {name: _describe(one, asked) for name, one in both.items()}
    chosen = max(both, key=lambda name: described[name]["probability"]["marginal"]["value"])
    paths = nominal.paths + robust.paths
    record = {**described, "chosen": chosen, "traced_draws": DRAWN, "paths": paths}
    # Of the nominal map and of each that was proposed, before its trace.
    record["predicted_share"] = predicted
    return Likeliest(both[chosen].one, found, record)


def scenarios_of(work: DesignWork, judged: Judged, asked: Asked) -> Scenarios:
    """Return draws of everything: resin and place for the model, all else as traced at a map."""
    response, factors = judged.response.shrunk(), judged.factors
    steps = draws_of(factors, asked)[:_DRAWS]
    states = [FilmState()]
    even = [np.ones(len(steps))]
    odd = [np.zeros(len(steps))]
    others = np.ones(len(factors), bool)
    for i, factor in enumerate(factors):
        z = steps[:, i]
        # Lagrange's weights of a parabola through steps of -STEP, 0 and STEP.
        below, above = (z * (z + side) / (2 * STEP**2) for side in (-STEP, STEP))
        if factor.name in judged.changes:
            states += [FilmState(change) for change in judged.changes[factor.name]]
            even += [below, above]
            odd += [below, above]
        elif factor.name == SHIFT:
            # The film shifted the other way is its mirror image.
            states.append(FilmState(shift=STEP * factor.sigma / work.pitch))
            even.append(below + above)
            odd.append(above - below)
        else:
            continue
        even[0] = even[0] - below - above
        others[i] = False
    rest = (steps[:, others] @ response.slope[others]) @ response.basis.T
    count = len(response.basis)
    position = np.arange(count) / (count - count % 2)
    return Scenarios(
        tuple(states), np.stack(even, axis=1), np.stack(odd, axis=1), rest, position,
        asked.gates.contrast_marginal,
    )  # fmt: skip


def _describe(judged: Judged, asked: Asked) -> dict[str, Any]:
    """Return how likely a map is within the limits, and its traced draws, fit for JSON."""
    limit = asked.gates.contrast_marginal
    return {
        "label": judged.one.label,
        **describe_likely(asked, judged.response, draws_of(judged.factors, asked)),
        "traced_contrast": judged.drawn.tolist(),
        "traced_within": int(np.sum(judged.drawn <= limit)),
    }
