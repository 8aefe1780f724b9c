import errno
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from mpfcad.errors import ExportError, InputError
from mpfcad.export import canonical_json, check_manifest, export_folder, write_manifest
from mpfcad.export import folder as export
from mpfcad.export.manifest import _sealed


def make(out, content="x", kind="run"):
    with export_folder(out, kind) as folder:
        (folder / "a.txt").write_text(content)
        (folder / "b.txt").write_text("b")
        write_manifest(folder, "job", kind)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("exchange", [True, False])
def test_new_export_replaces_the_old_one(tmp_path, monkeypatch, exchange):
    if not exchange:
        monkeypatch.setattr(export, "exchange", lambda *_: False)
    make(tmp_path / "e", "old")
    make(tmp_path / "e", "new")
    assert (tmp_path / "e" / "a.txt").read_text() == "new"
    assert names(tmp_path) == ["e"]
    check_manifest(tmp_path / "e")


@pytest.mark.parametrize("step", ["_hidden", "_publish", "_clear", "_release"])
def test_ctrl_c_at_the_beginning_or_the_end_leaves_nothing_hidden(tmp_path, monkeypatch, step):
    make(tmp_path / "e", "old")
    real = getattr(export, step)

    def interrupted(*given):
        signal.raise_signal(signal.SIGINT)
        return real(*given)

    monkeypatch.setattr(export, step, interrupted)
    # What runs in the background may have been started with the signal ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            make(tmp_path / "e", "new")
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert names(tmp_path) == ["e"]
    assert (tmp_path / "e/a.txt").read_text() == ("old" if step == "_hidden" else "new")


@pytest.mark.parametrize(
    "trouble", [OSError(errno.ENOSPC, "No space left"), OSError(errno.EIO, "Input/output error"),
                OSError("23404 requested and 1554 written")],
)  # fmt: skip
def test_a_full_disk_is_one_line_that_names_the_export(tmp_path, trouble):
    says = r"/e: cannot be written: "
    with pytest.raises(ExportError, match=says), export_folder(tmp_path / "e", "run"):
        raise trouble
    assert names(tmp_path) == []


def test_a_full_disk_of_other_files_names_the_file(tmp_path):
    other = tmp_path / "temporary" / "film.stl"
    with pytest.raises(ExportError, match=f"^{other}: cannot be written: No space left"):  # noqa: SIM117
        with export_folder(tmp_path / "e", "run"):
            raise OSError(errno.ENOSPC, "No space left", str(other))
    with pytest.raises(ExportError, match=r"/e: cannot be written: No space left"):  # noqa: SIM117
        with export_folder(tmp_path / "e", "run") as hidden:
            raise OSError(errno.ENOSPC, "No space left", str(hidden / "film.stl"))


def test_another_error_of_the_system_stays_what_it_is(tmp_path):
    with pytest.raises(FileNotFoundError), export_folder(tmp_path / "e", "run"):
        (tmp_path / "none").read_bytes()


@pytest.mark.parametrize("trouble", [KeyboardInterrupt, SystemExit, ValueError])
def test_failure_leaves_the_old_export_and_nothing_else(tmp_path, trouble):
    make(tmp_path / "e", "old")
    with pytest.raises(trouble), export_folder(tmp_path / "e", "run") as folder:
        (folder / "a.txt").write_text("half")
        raise trouble
    assert (tmp_path / "e" / "a.txt").read_text() == "old"
    assert names(tmp_path) == ["e"]


def test_killed_run_leaves_no_export_and_the_next_run_tidies(tmp_path):
    code = (
        "import sys, time\nfrom pathlib import Path\nfrom mpfcad.export import export_folder\n"
        f"with export_folder(Path({str(tmp_path / 'e')!r}), 'run') as folder:\n"
        "    (folder / 'a.txt').write_text('half')\n    print('ready', flush=True)\n"
        "    time.sleep(60)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    partial = tmp_path / f".e.partial-{process.pid}"
    make(tmp_path / "e", "first")
    assert partial.is_dir(), "the folder of a living run was removed"
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    process.stdout.close()
    assert (tmp_path / "e" / "a.txt").read_text() == "first"
    make(tmp_path / "e", "second")
    assert names(tmp_path) == ["e"]


def test_export_stranded_between_two_renames_is_put_back(tmp_path):
    make(tmp_path / "e", "old")
    (tmp_path / "e").rename(tmp_path / ".e.old-123")
    (tmp_path / ".e.old-123.lock").touch()
    with pytest.raises(ValueError, match="stop"), export_folder(tmp_path / "e", "run"):
        raise ValueError("stop")
    assert (tmp_path / "e" / "a.txt").read_text() == "old"
    assert names(tmp_path) == ["e"]


def test_foreign_folder_file_and_kind_are_refused(tmp_path):
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    (foreign / "thesis.doc").write_text("precious")
    (tmp_path / "file").write_text("precious")
    make(tmp_path / "mask", kind="mask")
    for out in (foreign, tmp_path / "file", tmp_path / "mask"):
        with pytest.raises(InputError, match=out.name):
            make(out)
    assert (foreign / "thesis.doc").read_text() == "precious"
    empty = tmp_path / "empty"
    empty.mkdir()
    make(empty)
    assert names(empty) == ["a.txt", "b.txt", "manifest.json"]


@pytest.mark.parametrize("name", ["a.txt", "b.txt", "manifest.json"])
@pytest.mark.parametrize("position", [0, -1])
def test_one_changed_byte_is_found_and_named(tmp_path, name, position):
    make(tmp_path / "e")
    check_manifest(tmp_path / "e")
    path = tmp_path / "e" / name
    content = bytearray(path.read_bytes())
    content[position] ^= 1
    path.write_bytes(content)
    with pytest.raises(ExportError, match=name):
        check_manifest(tmp_path / "e")


def test_every_byte_of_the_manifest_counts(tmp_path):
    make(tmp_path / "e")
    path = tmp_path / "e" / "manifest.json"
    whole = path.read_bytes()
    for i in range(len(whole)):
        changed = bytearray(whole)
        changed[i] ^= 0x20
        path.write_bytes(changed)
        with pytest.raises(ExportError, match=r"manifest\.json"):
            check_manifest(tmp_path / "e")


def test_missing_and_foreign_files_are_named(tmp_path):
    make(tmp_path / "e")
    (tmp_path / "e" / "extra").write_text("")
    with pytest.raises(ExportError, match="extra: not in the manifest"):
        check_manifest(tmp_path / "e")
    (tmp_path / "e" / "extra").unlink()
    (tmp_path / "e" / "b.txt").unlink()
    with pytest.raises(ExportError, match=r"b\.txt: missing"):
        check_manifest(tmp_path / "e")


def test_folder_without_manifest_is_no_export(tmp_path):
    with pytest.raises(InputError, match="no export"):
        check_manifest(tmp_path)


def test_manifest_is_the_same_at_any_time(tmp_path):
    make(tmp_path / "one")
    time.sleep(0.01)
    make(tmp_path / "two")
    texts = {(tmp_path / name / "manifest.json").read_text() for name in ("one", "two")}
    assert len(texts) == 1
    assert json.loads(texts.pop())["files"]["b.txt"]["bytes"] == 1


@pytest.mark.parametrize("exchange", [True, False])
def test_what_the_user_has_put_there_or_edited_is_kept(tmp_path, monkeypatch, capsys, exchange):
    if not exchange:
        monkeypatch.setattr(export, "exchange", lambda *_: False)
    out = tmp_path / "e"
    make(out, "old")
    (out / "notes.md").write_text("screen 12, Friday")
    (out / "photos").mkdir()
    (out / "photos" / "1.jpg").write_bytes(b"x")
    (out / "b.txt").write_text("edited by hand")
    (out / "link").symlink_to("a.txt")
    make(out, "new")
    assert (out / "a.txt").read_text() == "new" and (out / "b.txt").read_text() == "b"
    assert (out / "notes.md").read_text() == "screen 12, Friday"
    assert (out / "photos" / "1.jpg").is_file() and (out / "link").is_symlink()
    assert (out / "b.txt.kept-1").read_text() == "edited by hand"
    assert names(tmp_path) == ["e"]
    lines = capsys.readouterr().err
    assert "b.txt: was edited since it was made: kept as b.txt.kept-1" in lines
    assert "notes.md: is not of the export" in lines
    make(out, "third")
    assert (out / "b.txt.kept-1").is_file() and (out / "notes.md").is_file()


def test_a_file_that_the_new_export_makes_too_is_kept_under_another_name(tmp_path):
    out = tmp_path / "e"
    make(out)
    (out / "c.txt").write_text("mine")
    with export_folder(out, "run") as folder:
        (folder / "c.txt").write_text("made")
        write_manifest(folder, "job", "run")
    assert (out / "c.txt").read_text() == "made"
    assert (out / "c.txt.kept-1").read_text() == "mine"


def test_an_edited_manifest_loses_no_file(tmp_path):
    out = tmp_path / "e"
    make(out, "old")
    (out / "notes.md").write_text("mine")
    text = (out / "manifest.json").read_text()
    (out / "manifest.json").write_text(text.replace('"name": "job"', '"name": "jab"'))
    make(out, "new")
    assert names(out) == [
        "a.txt", "b.txt", "manifest.json", "manifest.json.kept-1", "notes.md",
    ]  # fmt: skip


def test_files_put_into_an_export_during_the_run_are_kept(tmp_path):
    make(tmp_path / "e")
    with export_folder(tmp_path / "e", "run") as folder:
        (tmp_path / "e" / "late.md").write_text("mine")
        write_manifest(folder, "job", "run")
    assert (tmp_path / "e" / "late.md").read_text() == "mine"


@pytest.mark.parametrize("what", ["partial", "old"])
def test_a_folder_that_only_looks_hidden_is_not_touched(tmp_path, what):
    """Neither a user's folder, nor an export whose name is like that of a hidden one."""
    theirs = [tmp_path / f".e.{what}-{end}" for end in ("7", "notes", "7-1")]
    make(theirs[0])
    for folder in theirs[1:]:
        folder.mkdir()
        (folder / "thesis.doc").write_text("precious")
    make(tmp_path / "e")
    assert names(theirs[0]) == ["a.txt", "b.txt", "manifest.json"]
    assert all((folder / "thesis.doc").is_file() for folder in theirs[1:])


def test_a_name_with_signs_of_a_pattern_takes_no_other_folder(tmp_path):
    make(tmp_path / ".eX.partial-1")
    (tmp_path / ".eX.partial-1.lock").touch()
    make(tmp_path / "e[X]")
    make(tmp_path / "e?")
    assert (tmp_path / ".eX.partial-1" / "a.txt").is_file()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"../b.txt": None}, "expected the name of a file in the folder itself"),
        ({"/etc/hostname": None}, "expected the name of a file in the folder itself"),
        ({"sub/b.txt": None}, "expected the name of a file in the folder itself"),
        ({"b.txt": "abc"}, "expected sha256 and bytes"),
        ({"b.txt": {"sha256": "0", "bytes": 1}}, "expected 64 hex digits"),
        ({"c.txt": None}, "c.txt: missing"),
    ],
)
def test_an_entry_that_mpfcad_does_not_write_is_refused(tmp_path, change, said):
    make(tmp_path / "e")
    path = tmp_path / "e" / "manifest.json"
    manifest = json.loads(path.read_text())
    whole = manifest["files"]["b.txt"]
    manifest["files"].update({k: whole if v is None else v for k, v in change.items()})
    path.write_text(canonical_json(_sealed(manifest)))
    with pytest.raises(ExportError, match=said):
        check_manifest(tmp_path / "e")


@pytest.mark.parametrize("text", ["", "[]", "null", "{", "[" * 100_000, '{"files": 3}', "\0" * 99])
def test_a_malformed_manifest_is_one_line(tmp_path, text):
    make(tmp_path / "e")
    (tmp_path / "e" / "manifest.json").write_text(text)
    with pytest.raises(ExportError, match=r"manifest\.json: changed"):
        check_manifest(tmp_path / "e")


def test_a_link_in_the_place_of_a_file_is_refused(tmp_path):
    make(tmp_path / "e")
    (tmp_path / "copy.txt").write_text("x")
    (tmp_path / "e" / "a.txt").unlink()
    (tmp_path / "e" / "a.txt").symlink_to(tmp_path / "copy.txt")
    with pytest.raises(ExportError, match=r"a\.txt: is a link"):
        check_manifest(tmp_path / "e")


def test_a_name_that_is_no_utf8_stands_in_the_manifest_and_is_found_again(tmp_path):
    with export_folder(tmp_path / "e", "run") as folder:
        (folder / os.fsdecode(b"\xff.txt")).write_text("x")
        write_manifest(folder, "job", "run")
    assert len(check_manifest(tmp_path / "e")["files"]) == 1
