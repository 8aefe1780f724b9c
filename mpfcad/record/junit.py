"""The gates as a JUnit report, which build servers show: a test case a gate."""

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

from mpfcad.boundary.out import asked_file, check_out

#: How a report begins.
_BEGINNING = b"<?xml version='1.0' encoding='utf-8'?>\n<testsuite"
#: Signs that no XML document may hold; a file's name may.
_NO_XML = re.compile("[^\\t\\n\\r\\x20-\\ud7ff\\ue000-\\ufffd\\U00010000-\\U0010ffff]")


def junit_report(record: dict[str, Any], *, changed: str | None = None) -> bytes:
    """Return the XML of a record's gates, MARGINAL as passed; the same record gives the same bytes.

    `changed`: what `mpfcad verify` found changed in the export, None where nothing was.
    """
    gates = record.get("gates", [])
    suite = Xml.Element("testsuite", name=f"mpfcad {record.get('name', '')}".strip())
    case = Xml.SubElement(suite, "testcase", classname="mpfcad", name="export_unchanged")
    if changed is not None:
        Xml.SubElement(case, "failure", message=changed)
    for gate in gates:
        case = Xml.SubElement(suite, "testcase", classname="mpfcad.gate", name=gate["name"])
        if gate["outcome"] not in ("PASS", "MARGINAL"):
            Xml.SubElement(case, "failure", message=_message(gate), type=gate["outcome"])
        Xml.SubElement(case, "system-out").text = _message(gate)
    cases = suite.findall("testcase")
    suite.set("tests", str(len(cases)))
    suite.set("failures", str(sum(case.find("failure") is not None for case in cases)))
    suite.set("errors", "0")
    for part in suite.iter():
        part.text = _NO_XML.sub("?", part.text) if part.text else None
        part.attrib.update({key: _NO_XML.sub("?", value) for key, value in part.attrib.items()})
    Xml.indent(suite)
    return Xml.tostring(suite, encoding="utf-8", xml_declaration=True) + b"\n"


def write_junit(path: Path, record: dict[str, Any], *, changed: str | None = None) -> None:
    """Write the report to `path`, whole or not at all."""
    with asked_file(path) as part:
        part.write_bytes(junit_report(record, changed=changed))


def check_junit(path: Path | None) -> None:
    """Refuse, before work, a report that cannot be written; None: none is asked for.

    Raises
    ------
    InputError
        when `path` is a folder, leads through a file, or is there and no JUnit report.
    """
    check_out("--junit", path, (_BEGINNING,))


def _message(gate: dict[str, Any]) -> str:
    sign = ">=" if gate.get("at_least") else "<="
    value = "not measured" if gate["value"] is None else f"{gate['value']:.6g}"
    words = f"{gate['outcome']}: {value}, expected {sign} {gate['limit']:.6g}"
    if "marginal_limit" in gate:
        words += f" (marginal {sign} {gate['marginal_limit']:.6g})"
    if gate["ci95"] is not None:
        words += f", 95 % interval {gate['ci95'][0]:.6g} to {gate['ci95'][1]:.6g}"
    return f"{words}: {gate['detail']}" if "detail" in gate else words
