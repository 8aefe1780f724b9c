"""How likely a contrast meets its limits, as a command prints it."""

from typing import Any

#: Inputs with the largest shares that are printed.
_INPUTS_SHOWN = 6


def print_confidence(confidence: dict[str, Any]) -> None:
    """Print how likely the limits are met, what that hangs on and what to measure next."""
    for found in confidence["probability"].values():
        low, high = found["ci95"]
        share = f"{found['value']:.2f} [{low:.2f}, {high:.2f}]"
        print(f"contrast at most {found['limit']:g}: {share} likely")
    low, high = confidence["contrast"]["ci95"]
    print(f"contrast with all widths {confidence['contrast']['value']:.4f} [{low:.4f}, {high:.4f}]")
    for one in confidence["inputs"][:_INPUTS_SHOWN]:
        bar = "#" * round(40 * one["share_of_variance"])
        print(f"  {one['name']:28} ± {one['sigma']:<7.3g} {one['share_of_variance']:5.0%} {bar}")
    if confidence["measure_next"]:
        first = confidence["measure_next"][0]
        print(
            f"measure next: {first['measurement']}: the contrast's 95 % range narrows from "
            f"{first['contrast_spread_before']:.4f} to {first['contrast_spread']:.4f}; "
            f"{first['probability_if_confirmed']:.2f} likely if it confirms the stated value"
        )


def case_words(case: dict[str, Any]) -> str:
    """Return how likely a case is accepted and what that hangs on most; empty where not asked."""
    if "confidence" not in case:
        return ""
    found = case["confidence"]["probability"]["marginal"]
    low, high = found["ci95"]
    first = case["confidence"]["inputs"][:1]
    hangs = "".join(f", most by {one['name']}" for one in first)
    return f"; at most {found['limit']:g}: {found['value']:.2f} [{low:.2f}, {high:.2f}]{hangs}"


def print_both(found: dict[str, Any]) -> None:
    """Print how likely the nominal design and that for confidence are within the limit."""
    for name in ("nominal", "confidence"):
        likely = found[name]["probability"]["marginal"]
        low, high = likely["ci95"]
        mark = ", chosen" if name == found["chosen"] else ""
        print(
            f"{name} design: at most {likely['limit']:g}: {likely['value']:.2f} "
            f"[{low:.2f}, {high:.2f}] likely; {found[name]['traced_within']} of "
            f"{found['traced_draws']} traced draws{mark}"
        )
