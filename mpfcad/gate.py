"""A gate: one figure against its limit. Checks measure and state their gates; nothing else judges.

A gate with an interval is decided by the interval, never by the value alone. Of the contrast's two
limits (PASS up to `limit`, MARGINAL up to `marginal`) and its 95 % interval [low, high]:

    high ≤ limit                  PASS          certainly within the first limit
    high ≤ marginal               MARGINAL      certainly within the second, not surely the first
    low > marginal                FAIL          certainly outside
    otherwise                     INCONCLUSIVE  the interval straddles the limit that accepts

So an interval across the first limit alone is MARGINAL: that much is certain, and it is never PASS.
Of a lower limit (`at_least`) the same holds, turned round. Comparisons are written so that NaN is
never a PASS.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

from mpfcad.errors import ExportError

Outcome = Literal["PASS", "MARGINAL", "INCONCLUSIVE", "FAIL"]
#: From best to worst; the verdict is the worst of its gates.
OUTCOMES: tuple[Outcome, ...] = ("PASS", "MARGINAL", "INCONCLUSIVE", "FAIL")


@dataclass(frozen=True)
class Gate:
    """One figure against its limit.

    Attributes
    ----------
    name
        what is judged, with the unit of its value as suffix
    value
        the figure; 1.0 or 0.0 for a yes/no gate, whose limit is 1; None where it was not measured
    limit
        the figure must be at most this (`at_least`: at least this)
    interval
        its 95 % interval, None for a figure without statistical error
    marginal
        the second, wider limit, if there is one
    at_least
        whether `limit` is a lower limit
    detail
        where the figure was found, or why there is none: one line, which begins with the file
    """

    name: str
    value: float | None
    limit: float
    interval: tuple[float, float] | None = None
    marginal: float | None = None
    at_least: bool = False
    detail: str = ""

    @property
    def outcome(self) -> Outcome:
        """PASS, MARGINAL, INCONCLUSIVE or FAIL, by the interval where there is one."""
        if self.value is None:
            return "INCONCLUSIVE"
        sign = -1.0 if self.at_least else 1.0
        limit = sign * self.limit
        widest = limit if self.marginal is None else sign * self.marginal
        if self.interval is None:
            value = sign * self.value
            return "PASS" if value <= limit else "MARGINAL" if value <= widest else "FAIL"
        low, high = sorted(sign * end for end in self.interval)
        if high <= limit:
            return "PASS"
        if high <= widest:
            return "MARGINAL"
        return "FAIL" if low > widest else "INCONCLUSIVE"

    def document(self) -> dict[str, Any]:
        """Return the gate as it stands in verification.json."""
        document: dict[str, Any] = {
            "name": self.name,
            "value": self.value,
            "ci95": None if self.interval is None else list(self.interval),
            "limit": self.limit,
        }
        if self.at_least:
            document["at_least"] = True
        if self.marginal is not None:
            document["marginal_limit"] = self.marginal
        if self.detail and self.outcome != "PASS":
            document["detail"] = self.detail
        return {**document, "outcome": self.outcome}


def yes_no(name: str, holds: bool, detail: str = "") -> Gate:
    """Return the gate of what holds or does not; `detail` says why not."""
    return Gate(name, float(holds), 1.0, at_least=True, detail=detail)


def worst_outcome(gates: Iterable[Gate]) -> Outcome:
    """Return the worst outcome of the gates; without any gate nothing is decided."""
    outcomes = [gate.outcome for gate in gates]
    return max(outcomes, key=OUTCOMES.index) if outcomes else "INCONCLUSIVE"


def worst_of_each(gates: Iterable[Gate]) -> list[Gate]:
    """Return one gate of each name, the worst: of several files, the one that is farthest off."""
    worst: dict[str, Gate] = {}
    for gate in gates:
        before = worst.get(gate.name)
        if before is None or _badness(gate) > _badness(before):
            worst[gate.name] = gate
    return list(worst.values())


def _badness(gate: Gate) -> tuple[int, float]:
    """Return what orders gates of one name, from good to bad."""
    value = 0.0 if gate.value is None else gate.value
    over = gate.limit - value if gate.at_least else value - gate.limit
    return OUTCOMES.index(gate.outcome), float("inf") if over != over else over


def demand(gates: Iterable[Gate]) -> None:
    """Raise for the first gate that is not passed.

    Raises
    ------
    ExportError
        naming the file, the figure and what was expected.
    """
    for gate in gates:
        if gate.outcome == "PASS":
            continue
        most = "at least" if gate.at_least else "at most"
        what = gate.name.replace("_", " ")
        figure = f"{what} {gate.value:.3g}: expected {most} {gate.limit:.3g}"
        raise ExportError(f"{gate.detail}: {figure}" if gate.detail else figure)


def exit_code(outcome: Outcome) -> int:
    """Return 0 for PASS and MARGINAL, 1 for FAIL and INCONCLUSIVE."""
    return 0 if outcome in ("PASS", "MARGINAL") else 1
