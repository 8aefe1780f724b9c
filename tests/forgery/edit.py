"""Forgeries of an export's files, held as bytes by name; None stands for a link to elsewhere."""

import hashlib
import json
import random
import re

Files = dict[str, bytes | None]
RECORD, PAGE, MAP = "verification.json", "report.html", "curvature.csv"
PICTURES = ("mask.png", "mask.lyrdb")
SOLIDS = ("film.step", "film.stl", "mask.oas", "mask.gds")


def digest(data: bytes) -> bytes:
    """Return the SHA-256 of bytes as hex digits."""
    return hashlib.sha256(data).hexdigest().encode()


def restated(original: Files, forged: Files) -> Files:
    """Return the forged files, new hashes standing in record and page where the old ones stood."""
    for name, data in forged.items():
        old = original.get(name)
        if not data or not old or data == old or name in (RECORD, PAGE):
            continue
        for stating in (RECORD, PAGE):
            forged[stating] = (forged[stating] or b"").replace(digest(old), digest(data))
    return forged


def places(value, where=()):
    """Yield the place of every leaf of a record."""
    entries = value.items() if isinstance(value, dict) else enumerate(value)
    for key, entry in entries:
        if isinstance(entry, dict | list) and entry:
            yield from places(entry, (*where, key))
        else:
            yield (*where, key)


def _other(rng, value):
    """Return another value in place of one."""
    ways = [None, "", "PASS", 0, 1.0, True, [], {}, float(rng.random())]
    if isinstance(value, bool):
        ways.append(not value)
    elif isinstance(value, int | float):
        ways += [value * (1 + 10.0 ** -rng.randrange(1, 10)), value + 1, -value, value / 2] * 4
    elif isinstance(value, str) and value:
        at = rng.randrange(len(value))
        ways += [value[:at] + rng.choice("0aZ é<") + value[at + 1 :], value + "x"] * 6
    return rng.choice([way for way in ways if repr(way) != repr(value)])


def _put(record, place, value):
    for key in place[:-1]:
        record = record[key]
    record[place[-1]] = value


def _leaf(record, place):
    for key in place:
        record = record[key]
    return record


def edit_record(rng, files: Files) -> Files:
    """Change one to three leaves of the record."""
    record = json.loads(files[RECORD])
    found = list(places(record))
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        place, inner = rng.choice(found), record
        for key in place[:-1]:
            inner = inner[key]
        how = rng.randrange(8)
        if how == 0 and isinstance(inner, dict):
            inner.pop(place[-1], None)
        elif how == 1 and isinstance(inner, dict):
            inner[f"{place[-1]}_too"] = 1
        elif isinstance(inner, list) or place[-1] in inner:
            inner[place[-1]] = _other(rng, inner[place[-1]])
    return {**files, RECORD: json.dumps(record, indent=1).encode()}


def edit_verdict(rng, files: Files) -> Files:
    """Change the verdict, or a gate's value, limit or outcome; on the page too where it stands."""
    record = json.loads(files[RECORD])
    words = ["PASS", "MARGINAL", "INCONCLUSIVE", "FAIL"]
    page = files[PAGE]
    for _ in range(rng.choice((1, 2, 3))):
        gate = rng.choice(record["gates"])
        key = rng.choice(["verdict", *gate])
        if key == "verdict":
            old, new = record["verdict"], rng.choice(words)
            record["verdict"] = new
            page = page.replace(old.encode(), new.encode())
        else:
            gate[key] = rng.choice(words) if key == "outcome" else _other(rng, gate[key])
    return {**files, RECORD: json.dumps(record, indent=1).encode(), PAGE: page}


def edit_job(rng, files: Files) -> Files:
    """Change a number of the job wherever the record states it: as given, resolved and an input."""
    record = json.loads(files[RECORD])
    job = record["job"]["resolved"]
    numbers = [p for p in places(job) if type(_leaf(job, p)) in (int, float) and len(p) == 2]
    place = rng.choice(numbers)
    value = rng.choice([_leaf(job, place) * (1 + 10.0 ** -rng.randrange(1, 6)), 0.03, 1.0])
    _put(job, place, value)
    record["job"]["given"].setdefault(place[0], {})[place[1]] = value
    for entry in record["inputs"]:
        if entry["name"] == ".".join(place):
            entry.update(value=value, tag="given", source="the job")
    for gate in record["gates"]:
        if place[1] == "contrast_pass" and gate["name"] == "lamp_mura_contrast":
            gate["limit"] = value
    return {**files, RECORD: json.dumps(record, indent=1).encode()}


def edit_page(rng, files: Files) -> Files:
    """Change what a reader of the page sees: a word or a figure between two tags."""
    page = files[PAGE].decode()
    # Behind the plots' library, which is most of the page.
    shown = [m for m in re.finditer(r">([^<>{}]{2,200})<", page) if m[1].strip()]
    one = rng.choice(shown)
    text = list(one[1])
    digits = [i for i, c in enumerate(text) if c.isdigit()]
    at = rng.choice(digits) if digits and rng.random() < 0.7 else rng.randrange(len(text))
    text[at] = rng.choice("0123456789" if text[at].isdigit() else "aeo <")
    return {**files, PAGE: (page[: one.start(1)] + "".join(text) + page[one.end(1) :]).encode()}


def edit_both(rng, files: Files) -> Files:
    """Change a figure of the record to another, and to the same one wherever the page shows it."""
    record, page = json.loads(files[RECORD]), files[PAGE].decode()
    floats = [p for p in places(record) if type(_leaf(record, p)) is float and _leaf(record, p)]
    place = rng.choice(floats)
    old = _leaf(record, place)
    new = old * (1 + rng.choice((-0.3, 0.5, 0.1, 0.01, -1e-3)))
    _put(record, place, new)
    for digits in range(2, 7):
        shown = re.escape(f"{old:.{digits}g}")
        page = re.sub(rf"(?<![\d.]){shown}(?!\d)", f"{new:.{digits}g}", page)
    return {**files, RECORD: json.dumps(record, indent=1).encode(), PAGE: page.encode()}


def _edited(rng, data: bytes) -> bytes:
    out = bytearray(data)
    at, how = rng.randrange(len(out)), rng.randrange(4)
    if how == 0:
        out[at] ^= 1 << rng.randrange(8)
    elif how == 1:
        digits = [m.start() for m in re.finditer(rb"\d", bytes(out[at : at + 4000]))]
        if digits:
            out[at + rng.choice(digits)] = rng.choice(b"0123456789")
    elif how == 2:
        del out[at : at + rng.choice((1, 7, 100))]
    else:
        out[at:at] = rng.choice((b" ", b"0", b"\n", out[at : at + 50]))
    return bytes(out)


def edit_picture(rng, files: Files) -> Files:
    """Change a picture or the markers."""
    name = rng.choice([name for name in PICTURES if name in files])
    return {**files, name: _edited(rng, files[name])}


def edit_solid(rng, files: Files) -> Files:
    """Change bytes of a mask or a CAD file."""
    name = rng.choice(SOLIDS)
    return {**files, name: _edited(rng, files[name])}


def edit_map(rng, files: Files) -> Files:
    """Change a figure of the map, or its rows."""
    rows = files[MAP].decode().splitlines()
    i, j = (rng.randrange(1, len(rows)) for _ in range(2))
    how = rng.randrange(5)
    if how == 0:
        rows[i], rows[j] = rows[j], rows[i]
    elif how == 1:
        del rows[i]
    elif how == 2:
        rows.insert(i, rows[j])
    else:
        cells = rows[i].split(",")
        at = rng.randrange(len(cells))
        digits = [k for k, c in enumerate(cells[at]) if c.isdigit()] or [0]
        k = rng.choice(digits)
        cells[at] = cells[at][:k] + rng.choice("0123456789e- ") + cells[at][k + 1 :]
        rows[i] = ",".join(cells)
    return {**files, MAP: ("\n".join(rows) + "\n").encode()}


def edit_names(rng, files: Files) -> Files:
    """Rename, add, drop, link or exchange files."""
    forged, names = dict(files), list(files)
    name, other = rng.sample(names, 2)
    how = rng.randrange(5)
    if how == 0:
        forged[rng.choice(["copy-", ".", "Z"]) + name] = forged.pop(name)
    elif how == 1:
        extra = rng.choice(["release.html", "mask2.oas", "film.3mf", "report.txt", "mask.dxf"])
        forged[extra] = rng.choice([b"PASS", files[name]])
    elif how == 2:
        del forged[name]
    elif how == 3:
        forged[name] = None
    else:
        forged[name], forged[other] = files[other], files[name]
    return forged


def edit_manifest(rng: random.Random, manifest: dict) -> None:
    """Change what a manifest states, in place; it is sealed afterwards."""
    name = rng.choice(list(manifest["files"]))
    entry = manifest["files"][name]
    how = rng.randrange(7)
    if how == 0:
        manifest["name"] = rng.choice(["another", "", 5, None])
    elif how == 1:
        manifest["kind"] = rng.choice(["mask", "design", "", 0])
    elif how == 2:
        manifest["schema"] = rng.choice([2, "1", None, True])
    elif how == 3:
        manifest[rng.choice(["note", "verdict", "signed"])] = "PASS"
    elif how == 4:
        path = rng.choice(["../out.json", "/etc/hostname", "a/b", "C:x", "."])
        manifest["files"][path] = dict(entry)
    elif how == 5:
        entry["bytes"] = rng.choice([entry["bytes"] + 1, float(entry["bytes"]), True, None])
    else:
        entry["sha256"] = rng.choice(["0" * 64, entry["sha256"].upper(), "", None])


#: Ways to forge, each as often as it stands here.
WAYS = (
    [edit_record] * 40 + [edit_verdict] * 12 + [edit_job] * 6 + [edit_page] * 14 + [edit_map] * 10
    + [edit_both] * 10 + [edit_picture] * 4 + [edit_solid] * 4 + [edit_names] * 6
    + [edit_manifest] * 4
)  # fmt: skip
