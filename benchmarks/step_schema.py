"""A STEP file held against the EXPRESS schema of its protocol, entity by entity.

    python benchmarks/step_schema.py SCHEMA.exp FILE.step…

SCHEMA is ISO 10303-214's or -242's long form, as STEPcode (github.com/stepcode/stepcode) has it in
`data/`. steputils parses the file; no CAD kernel takes part. Of each instance it is asked: whether
there is such an entity, not an abstract one; whether it has as many attributes as the schema
declares, inherited ones first; whether each is of its declared type, through selects, enumerations
and aggregates with their bounds; whether what it refers to is there, and of the right kind; whether
the parts of a complex instance are whole and in order. WHERE rules are not evaluated. Exit code 1
where a file has a fault.
"""

import re
import sys
from collections import Counter
from pathlib import Path
from typing import Any

from steputils import p21

_END = r"\b(?:DERIVE|INVERSE|WHERE|UNIQUE(?=\s+\w+\s*:))\b"
_MANY = re.compile(
    r"(set|list|bag|array)\s*(?:\[\s*([^:\]]+)\s*:\s*([^\]]+)\])?\s*of\s+(?:unique\s+|optional\s+)*(.*)"
)
#: Plain types, and what steputils makes of them.
_PLAIN = {
    "real": p21.is_real, "integer": p21.is_integer, "string": p21.is_string,
    "number": lambda v: p21.is_real(v) or p21.is_integer(v),
    "boolean": lambda v: str(v) in (".T.", ".F."),
    "logical": lambda v: str(v) in (".T.", ".F.", ".U."),
}  # fmt: skip


class Schema:
    """Types and entities of an EXPRESS schema, by their names in lower case."""

    def __init__(self, text: str) -> None:
        text = re.sub(r"--[^\n]*", " ", re.sub(r"\(\*.*?\*\)", " ", text, flags=re.DOTALL))
        found = re.finditer(r"\bTYPE\s+(\w+)\s*=\s*(.*?);", text, re.DOTALL | re.IGNORECASE)
        self.types = {m[1].lower(): " ".join(m[2].split()).lower() for m in found}
        self.supers: dict[str, list[str]] = {}
        self.own: dict[str, list[tuple[str, str, str]]] = {}
        self.derived: dict[str, set[tuple[str, str]]] = {}
        self.renewed: dict[str, dict[tuple[str, str], str]] = {}
        self.abstract: set[str] = set()
        for m in re.finditer(
            r"\bENTITY\s+(\w+)(.*?)END_ENTITY\s*;", text, re.DOTALL | re.IGNORECASE
        ):
            self._take(m[1].lower(), m[2].lower())

    def _take(self, name: str, body: str) -> None:
        head, _, rest = body.partition(";")
        over = re.search(r"subtype\s+of\s*\(([^)]*)\)", head)
        self.supers[name] = [word.strip() for word in over[1].split(",")] if over else []
        if "abstract" in head:
            self.abstract.add(name)
        derive = re.search(r"\bderive\b(.*?)(?:\binverse\b|\bwhere\b|$)", rest, re.DOTALL)
        again = re.findall(r"self\\(\w+)\.(\w+)\s*:", derive[1]) if derive else []
        self.derived[name] = set(again)
        self.own[name], self.renewed[name] = [], {}
        for part in re.split(_END, rest, maxsplit=1, flags=re.IGNORECASE)[0].split(";"):
            names, colon, kind = (" ".join(p.split()) for p in part.partition(":"))
            for each in (n.strip() for n in names.split(",") if colon):
                other = re.match(r"self\\(\w+)\.(\w+)", each)
                if other:
                    self.renewed[name][other[1], other[2]] = kind
                else:
                    self.own[name].append((name, each, kind))

    def above(self, name: str) -> list[str]:
        """Return an entity and all that it is a subtype of, those first."""
        found: list[str] = []
        for each in self.supers[name]:
            found += [n for n in self.above(each) if n not in found]
        return [*found, name]

    def choices(self, kind: str) -> list[str]:
        """Return what a select, or an enumeration, lists; empty for another type."""
        own = self.types.get(kind, "")
        listed = "(" in own and re.match(r"(extensible )?(generic_entity )?(select|enum)", own)
        return (
            [c.strip() for c in own[own.index("(") + 1 : own.rindex(")")].split(",")]
            if listed
            else []
        )


class File:
    """A file's instances, and what is wrong with them."""

    def __init__(self, schema: Schema, path: str) -> None:
        self.schema, self.faults = schema, Counter[str]()
        self.parts: dict[str, list[Any]] = {}
        for each in p21.readfile(path).data[0].instances.values():
            whole = p21.is_complex_entity_instance(each)
            self.parts[each.ref] = list(each.entities) if whole else [each.entity]
        self.kinds: dict[str, set[str]] = {}
        for ref, parts in self.parts.items():
            names = [p.name.lower() for p in parts if p.name.lower() in schema.own]
            self.kinds[ref] = {n for name in names for n in schema.above(name)}
        for parts in self.parts.values():
            self._check(parts)

    def _check(self, parts: list[Any]) -> None:
        names = [part.name.lower() for part in parts]
        unknown = [n for n in names if n not in self.schema.own]
        if unknown:
            self.faults[f"{unknown[0]}: no such entity"] += 1
            return
        above = [self.schema.above(name) for name in names]
        if len(parts) > 1 and (
            names != sorted(names, key=str.upper) or set(names) != set().union(*above)
        ):
            self.faults[f"{names}: not whole, or not in order"] += 1
        if len(parts) == 1 and names[0] in self.schema.abstract:
            self.faults[f"{names[0]}: abstract"] += 1
        every = [n for line in above for n in line]
        for part, name, line in zip(parts, names, above, strict=True):
            owners = [name] if len(parts) > 1 else line
            wanted = [attribute for owner in owners for attribute in self.schema.own[owner]]
            if len(wanted) != len(part.params):
                self.faults[f"{name}: {len(part.params)} attributes, not {len(wanted)}"] += 1
                continue
            for (owner, attribute, kind), value in zip(wanted, part.params, strict=True):
                why = self._attribute((owner, attribute), kind, value, every)
                if why:
                    self.faults[f"{name}.{attribute}: {why}"] += 1

    def _attribute(self, place: tuple[str, str], kind: str, value: Any, above: list[str]) -> str:
        if any(place in self.schema.derived[name] for name in above):
            return "" if str(value) == "*" else "derived: expected *"
        for name in above:
            kind = self.schema.renewed[name].get(place, kind)
        if str(value) == "$":
            return "" if kind.startswith("optional ") else "not optional"
        return self._type(kind.removeprefix("optional "), value)

    def _type(self, kind: str, value: Any) -> str:
        """Return why a value is not of a type; empty: it is."""
        many = _MANY.match(kind)
        if many:
            return self._aggregate(many, value)
        if kind in self.schema.own:
            found = self.kinds.get(value) if p21.is_reference(value) else None
            return "" if found is not None and kind in found else f"{value!r}: expected {kind}"
        choices = self.schema.choices(kind)
        if "enum" in self.schema.types.get(kind, "").split("(")[0]:
            return "" if str(value).strip(".").lower() in choices else f"{value} is no {kind}"
        if choices and p21.is_typed_parameter(value):
            named = value.type_name.lower()
            return (
                self._type(named, value.param)
                if self._leads(kind, named)
                else f"{named}: no {kind}"
            )
        if choices:
            return "" if any(not self._type(c, value) for c in choices) else f"{value}: no {kind}"
        if kind in self.schema.types:
            return self._type(self.schema.types[kind], value)
        base = kind.split("(")[0].strip()
        return "" if base in _PLAIN and _PLAIN[base](value) else f"{value!r}: expected {base}"

    def _aggregate(self, many: re.Match[str], value: Any) -> str:
        if not isinstance(value, tuple | list):
            return f"{value!r}: expected a {many[1]}"
        low, high = (bound.strip() if bound else "" for bound in (many[2], many[3]))
        if low.isdigit() and len(value) < int(low):
            return f"{len(value)} of them: expected {low} or more"
        if high.isdigit() and many[1] != "array" and len(value) > int(high):
            return f"{len(value)} of them: expected up to {high}"
        if many[1] == "set" and len({str(each) for each in value}) < len(value):
            return "a set with equal members"
        return next((why for why in (self._type(many[4], each) for each in value) if why), "")

    def _leads(self, kind: str, name: str) -> bool:
        return kind == name or any(self._leads(c, name) for c in self.schema.choices(kind))


def main() -> int:
    """Check the files named on the command line; return the exit code."""
    if len(sys.argv) < 3:
        print(__doc__)
        return 2
    schema = Schema(Path(sys.argv[1]).read_text(encoding="latin-1"))
    worst = 0
    for path in sys.argv[2:]:
        file = File(schema, path)
        kinds = {part.name for parts in file.parts.values() for part in parts}
        count = f"{len(file.parts):,} instances of {len(kinds)} kinds"
        print(f"{path}: {count}, {file.faults.total()} faults")
        for fault, number in file.faults.most_common(20):
            print(f"  {number} × {fault}")
        worst = max(worst, int(bool(file.faults)))
    return worst


if __name__ == "__main__":
    sys.exit(main())
