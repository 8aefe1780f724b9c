"""Forgeries without a key, every hash computed anew, are found by what they change.

The trace is not repeated for each: it is taken to give what it gave before, which favours the
forger. An edit that passes so must have changed no figure, page or verdict, or what was traced;
of those, some are traced again.
"""

import json
import random
import re
import shutil
from collections import Counter

import pytest
from command import SMALL_STACK

from mpfcad.errors import ExportError
from mpfcad.export import sha256, write_manifest
from mpfcad.job import read_job
from mpfcad.pipeline import TRACE_SETTINGS, TraceSetting, run_job, verify_export
from mpfcad.pipeline.plan.restored import stored_job
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run import examine as examined
from mpfcad.pipeline.run import verify

JOB = 'name = "forged"\n[map]\ncurvature_per_mm = 60.0\n' + SMALL_STACK
RECORD, PAGES = "verification.json", ("report.html", "mask.png", "mask.lyrdb")
#: What is not repeated of `examine`.
TRACES = ("trace_luminance", "survey_directions", "trace_plain", "find_printed")
FILES = ("curvature.csv", "film.step", "film.stl", "mask.oas", "mask.gds")


@pytest.fixture(scope="module")
def export(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exports")
    (folder / "job.toml").write_text(JOB)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(TRACE_SETTINGS, "quick", TraceSetting(half_width_goal=1.0, path_limit=20_000))
        for name in TRACES:
            patch.setattr(examined, name, _first(getattr(examined, name)))
        patch.setattr(examined, "examine_foreign", _once(examined.examine_files))
        patch.setattr(verify, "_find_again", _drawn_once(verify._find_again))
        run_job(read_job(folder / "job.toml"), folder / "job.toml", folder / "e", effort="quick")
        yield folder / "e"


def _first(trace):
    """Return a function that gives what it gave the first time."""
    kept = []

    def again(*arguments, **options):
        if not kept:
            kept.append(trace(*arguments, **options))
        return kept[0]

    return again


def _files(folder):
    return tuple(sha256(folder / name) for name in FILES)


def _once(examine_files):
    """Return `examine_files` that keeps what it found of the same files of the same job."""
    kept = {}

    def again(folder, plan, mask, progress):
        key = (_files(folder), json.dumps(stored_job(plan), sort_keys=True, default=str))
        if key not in kept:
            kept.clear() if len(kept) > 3 else None
            kept[key] = examine_files(folder, plan, mask, SILENT, foreign=True)
        return kept[key]

    return again


def _drawn_once(find_again):
    """Return `_find_again` that keeps the pages of the same record and files."""
    kept = {}

    def again(folder, stored, threads, progress):
        record, draw = find_again(folder, stored, threads, progress)

        def drawn(given):
            key = (_files(folder), json.dumps(given))
            if key not in kept:
                kept.clear() if len(kept) > 3 else None
                kept[key] = draw(given)
            return kept[key]

        return record, drawn

    return again


def _places(value, where=()):
    """Yield the place of every leaf."""
    entries = value.items() if isinstance(value, dict) else enumerate(value)
    for key, entry in entries:
        if isinstance(entry, dict | list) and entry:
            yield from _places(entry, (*where, key))
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


def _edited_record(rng, text, places):
    """Return a record in which one to three leaves are other ones, and where they stand."""
    record, changed = json.loads(text), []
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        place = rng.choice(places)
        inner = record
        for key in place[:-1]:
            inner = inner[key]
        how = rng.randrange(8)
        if how == 0 and isinstance(inner, dict):
            inner.pop(place[-1], None)
        elif how == 1 and isinstance(inner, dict):
            inner[f"{place[-1]}_too"] = 1
        elif isinstance(inner, list) or place[-1] in inner:
            inner[place[-1]] = _other(rng, inner[place[-1]])
        changed.append(".".join(map(str, place)))
    return json.dumps(record, indent=1), changed


def _edited_file(rng, data):
    data = bytearray(data)
    how = rng.randrange(4)
    at = rng.randrange(len(data))
    if how == 0:
        data[at] ^= 1 << rng.randrange(8)
    elif how == 1:
        digits = [m.start() for m in re.finditer(rb"\d", bytes(data[at : at + 4000]))]
        if digits:
            data[at + rng.choice(digits)] = rng.choice(b"0123456789")
    elif how == 2:
        del data[at : at + rng.choice((1, 7, 100))]
    else:
        data[at:at] = rng.choice((b" ", b"0", b"\n", data[at : at + 50]))
    return bytes(data)


def forge(rng, folder, original, places):
    """Edit one file; have the record and the page state the new hash where they stated the old."""
    name = rng.choice((RECORD,) * 30 + PAGES * 2 + FILES)
    if name == RECORD:
        text, changed = _edited_record(rng, original[RECORD], places)
        (folder / RECORD).write_text(text)
        return name, changed
    data = _edited_file(rng, original[name])
    (folder / name).write_bytes(data)
    if rng.random() < 0.8:
        old, new = (sha256_of(part) for part in (original[name], data))
        for stating in (RECORD, "report.html"):
            if stating != name:
                stated = original[stating].replace(old, new)
                (folder / stating).write_bytes(stated)
    return name, []


def sha256_of(data):
    import hashlib

    return hashlib.sha256(data).hexdigest().encode()


def figures(text):
    """Return a record without hashes and without what only the run could know."""
    record = json.loads(text)
    for key in ("sha256", "traced", "inputs_sha256", "versions", "code_sha256"):
        record["provenance"].pop(key, None)
    # What a trace would tell: with another seed or end it is another trace.
    record["job"].pop("trace", None)
    return record


def attack(folder, times, seed):
    """Return how many forgeries were found, and the others: where they were made."""
    original = {path.name: path.read_bytes() for path in folder.iterdir()}
    places = list(_places(json.loads(original[RECORD])))
    rng, found, passed = random.Random(seed), Counter(), []
    for _ in range(times):
        name, changed = forge(rng, folder, original, places)
        now = {key: (folder / key).read_bytes() for key in original}
        differs = now != original
        try:
            stored = verify.read_record(folder / RECORD)
            with verify.checked_record(folder, stored):
                verify._check(folder, stored, 1, SILENT, [])
            if differs:
                passed.append((name, changed, now))
        except ExportError:
            found[name] += 1
        for key, content in original.items():
            if now[key] != content:
                (folder / key).write_bytes(content)
    return found, passed, original


def check(folder, times, seed):
    """Assert that what passed changed no figure, page or verdict, as those names are meant."""
    found, passed, original = attack(folder, times, seed)
    assert sum(found.values()) > 0.8 * times, found
    for name, changed, now in passed:
        if name == RECORD:
            # Either written otherwise (-0.0), or what only a signature protects.
            same = figures(now[RECORD]) == figures(original[RECORD])
            assert same, (changed, "passed")
        else:
            assert name in FILES, name
            assert figures(now[RECORD]) == figures(original[RECORD]), name
    return found, passed


def test_forgeries_without_a_key_are_found(export):
    check(export, 25, seed=1)


@pytest.mark.slow
def test_ten_thousand_forgeries_without_a_key_are_found(export):
    check(export, 10_000, seed=2)


@pytest.mark.slow
def test_some_forgeries_are_found_by_tracing_again(export, tmp_path):
    """A figure of the trace, forged in the record and on the page alike."""
    rng = random.Random(3)
    for number in range(12):
        folder = shutil.copytree(export, tmp_path / str(number))
        record = json.loads((folder / RECORD).read_text())
        value = record["luminance"]["luminance_cd_m2"]
        value[rng.randrange(len(value))] *= 1 + 1e-6
        (folder / RECORD).write_text(json.dumps(record))
        write_manifest(folder, "forged", "run")
        with pytest.raises(ExportError, match="luminance"):
            verify_export(folder)
