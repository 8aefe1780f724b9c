import json
import os
import signal
import subprocess
import sys
import time

import pytest

from mpfcad import export
from mpfcad.errors import ExportError, InputError
from mpfcad.export import check_manifest, export_folder, write_manifest


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
        monkeypatch.setattr(export, "_exchange", lambda *_: False)
    make(tmp_path / "e", "old")
    make(tmp_path / "e", "new")
    assert (tmp_path / "e" / "a.txt").read_text() == "new"
    assert names(tmp_path) == ["e"]
    check_manifest(tmp_path / "e")


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
