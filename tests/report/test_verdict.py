import math
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpfcad.record import OUTCOMES, Gate, exit_code, junit_report, worst_outcome
from mpfcad.report.film.wording import verdict_sentence


def contrast(low, high):
    return Gate("lamp_mura_contrast", (low + high) / 2, 0.012, (low, high), 0.018)


@pytest.mark.parametrize(
    ("low", "high", "outcome"),
    [
        (0.001, 0.012, "PASS"),
        (0.001, 0.0121, "MARGINAL"),
        (0.013, 0.017, "MARGINAL"),
        (0.013, 0.018, "MARGINAL"),
        (0.013, 0.0181, "INCONCLUSIVE"),
        (0.001, 0.03, "INCONCLUSIVE"),
        (0.018, 0.03, "INCONCLUSIVE"),
        (0.0181, 0.03, "FAIL"),
        (math.nan, math.nan, "INCONCLUSIVE"),
    ],
)
def test_interval_decides(low, high, outcome):
    assert contrast(low, high).outcome == outcome


def test_value_inside_the_limit_does_not_pass_with_a_wide_interval():
    assert contrast(-0.01, 0.025).value < 0.012
    assert contrast(-0.01, 0.025).outcome == "INCONCLUSIVE"


@given(st.floats(0, 0.05), st.floats(0, 0.05), st.floats(0, 0.01))
def test_a_wider_interval_never_improves_the_outcome(a, b, more):
    low, high = min(a, b), max(a, b)
    before = contrast(low, high).outcome
    after = contrast(low - more, high + more).outcome
    if before == "FAIL":
        assert after in ("FAIL", "INCONCLUSIVE")
    else:
        assert OUTCOMES.index(after) >= OUTCOMES.index(before)


def test_gate_without_interval():
    assert Gate("x", 1.0, 1.0).outcome == "PASS"
    assert Gate("x", 1.1, 1.0).outcome == "FAIL"
    assert Gate("x", math.nan, 1.0).outcome == "FAIL"
    assert Gate("x", 1.0, 1.0, at_least=True).outcome == "PASS"
    assert Gate("x", 0.0, 1.0, at_least=True).outcome == "FAIL"


def test_verdict_is_the_worst_gate():
    good, bad = Gate("good", 0, 1), Gate("bad", 2, 1)
    unclear = contrast(0.01, 0.02)
    assert worst_outcome([good]) == "PASS"
    assert worst_outcome([good, contrast(0.013, 0.014)]) == "MARGINAL"
    assert worst_outcome([unclear, good]) == "INCONCLUSIVE"
    assert worst_outcome([unclear, bad, good]) == "FAIL"
    assert worst_outcome([]) == "INCONCLUSIVE"


def test_exit_codes():
    assert [exit_code(outcome) for outcome in OUTCOMES] == [0, 0, 1, 1]


def test_under_leds_the_verdict_speaks_of_leds():
    gate = {"outcome": "FAIL", "value": 0.1, "limit": 0.012, "marginal_limit": 0.018}
    assert "the lamps are visible" in verdict_sentence({"gates": [gate]})
    assert "the LEDs are visible" in verdict_sentence({"gates": [gate], "cell": {"order": 1}})


def test_a_junit_report_holds_only_signs_that_xml_may():
    """A changed export may name a file as its forger likes."""
    detail = "film\x00\x1b[31m.stl: \ud800 changed\n<&>"
    gate = {"name": "step_valid", "outcome": "FAIL", "value": 0.0, "limit": 1.0, "ci95": None,
            "detail": detail}  # fmt: skip
    written = junit_report({"name": "a", "gates": [gate]}, changed=detail)
    suite = ElementTree.fromstring(written)
    assert suite.find("testcase/failure").get("message") == "film??[31m.stl: ? changed\n<&>"
    assert suite.get("failures") == "2"
