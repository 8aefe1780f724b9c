"""Gates and the verdict: what is decided, from which figure, against which limit.

A gate with an interval is decided by the interval, never by the value alone. Of the contrast's two
limits (PASS up to `limit`, MARGINAL up to `marginal`) and its 95 % interval [low, high]:

    high ≤ limit                  PASS          certainly within the first limit
    high ≤ marginal               MARGINAL      certainly within the second, not surely the first
    low > marginal                FAIL          certainly outside
    otherwise                     INCONCLUSIVE  the interval straddles the limit that accepts

So an interval across the first limit alone is MARGINAL: that much is certain, and it is never PASS.
Comparisons are written so that NaN is never a PASS.
"""

from dataclasses import dataclass
from typing import Any, Literal

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
        the figure; 1.0 or 0.0 for a yes/no gate, whose limit is 1
    limit
        the figure must be at most this (`at_least`: at least this)
    interval
        its 95 % interval, None for a figure without statistical error
    marginal
        the second, wider limit, if there is one
    at_least
        whether `limit` is a lower limit
    """

    name: str
    value: float
    limit: float
    interval: tuple[float, float] | None = None
    marginal: float | None = None
    at_least: bool = False

    @property
    def outcome(self) -> Outcome:
        """PASS, MARGINAL, INCONCLUSIVE or FAIL, by the interval where there is one."""
        if self.interval is None:
            within = self.value >= self.limit if self.at_least else self.value <= self.limit
            return "PASS" if within else "FAIL"
        low, high = self.interval
        widest = self.limit if self.marginal is None else self.marginal
        if high <= self.limit:
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
        return {**document, "outcome": self.outcome}


def worst_outcome(gates: list[Gate]) -> Outcome:
    """Return the worst outcome of the gates; without any gate nothing is decided."""
    if not gates:
        return "INCONCLUSIVE"
    return max((gate.outcome for gate in gates), key=OUTCOMES.index)


def exit_code(outcome: Outcome) -> int:
    """Return 0 for PASS and MARGINAL, 1 for FAIL and INCONCLUSIVE."""
    return 0 if outcome in ("PASS", "MARGINAL") else 1
