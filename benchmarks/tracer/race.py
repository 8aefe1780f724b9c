"""Two tracers by turns: paths a CPU second, CPU seconds to an error, whether they agree."""

import time

import numpy as np

#: The threads of a tracer that has just ended look for work for some 20 ms more [s].
_REST = 0.2


def spent(call, *arguments):
    """Return a call's result and its CPU seconds, without those of the call before."""
    time.sleep(_REST)
    start = time.process_time()
    result = call(*arguments)
    return result, time.process_time() - start


def entry(name, ours, unit, *, peer=None, ratio=None, goal=None, same=True):
    """Return a row; a goal is met only where both give the same answer."""
    met = None if goal is None or ratio is None else bool(ratio >= goal and same)
    return {"name": name, "ours": ours, "peer": peer, "unit": unit, "ratio": ratio,
            "goal": goal and f"≥ {goal}×", "met": met}  # fmt: skip


def equal(values, errors):
    """Return whether two figures are within 5 standard errors and 1 % of each other."""
    away = abs(values[0] - values[1])
    return away <= 5 * np.hypot(*errors) and away <= 0.01 * abs(values[0])


def race(name, mine, theirs, counts, rounds, goal):
    """Trace by turns; yield paths a CPU second of both, what an error costs, the two figures."""
    mine(1, 1), theirs(counts[1], 1)
    rates, figures, costs = ([], []), ([], []), ([], [])
    for seed in range(2, 2 + rounds):
        for k, tracer in enumerate((mine, theirs)):
            result, cpu = spent(tracer, counts[k], seed)
            rates[k].append((result[2] if k == 0 else counts[k]) / cpu)
            figures[k].append(result[:2])
            costs[k].append(cpu * result[1] ** 2)
    best = [max(r) / 1e3 for r in rates]
    values = [np.mean([f[0] for f in fig]) for fig in figures]
    errors = [np.sqrt(np.sum([f[1] ** 2 for f in fig])) / len(fig) for fig in figures]
    yield entry(name, best[0], "k/s", peer=best[1], ratio=best[0] / best[1], goal=goal,
                same=equal(values, errors))  # fmt: skip
    cost = [1e8 * np.mean(c) for c in costs]
    title = f"    {name.partition(', beside')[0]}: to a standard error of 0.0001"
    yield entry(title, cost[0], "s", peer=cost[1], ratio=cost[1] / cost[0])
    away = abs(values[0] - values[1]) / np.hypot(*errors)
    yield entry(f"    figures; {away:.1f} σ apart", values[0], "", peer=values[1])
