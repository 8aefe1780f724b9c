"""A signed export: every change is found by the key, also where every hash was computed anew."""

import json
import random
import subprocess

import pytest
from test_export import make

from mpfcad.cli import run_app
from mpfcad.errors import ExportError, InputError
from mpfcad.export import check_manifest, write_manifest
from mpfcad.export.signature import check_signature, sign_export


def new_key(path, kind="ed25519"):
    command = ["ssh-keygen", "-q", "-t", kind, "-N", "", "-C", "maker", "-f", str(path)]
    subprocess.run(command, check=True, capture_output=True)
    return path


@pytest.fixture
def key(tmp_path):
    return new_key(tmp_path / "key")


@pytest.fixture
def signed(tmp_path, key):
    make(tmp_path / "e")
    sign_export(tmp_path / "e", key)
    return tmp_path / "e"


def test_a_signature_is_checked_by_the_public_key_or_a_list(signed, key, tmp_path):
    public = tmp_path / "key.pub"
    assert check_signature(signed, public) == str(public)
    check_manifest(signed)
    signers = tmp_path / "allowed"
    signers.write_text(f'ann@works namespaces="mpfcad-export" {public.read_text()}')
    assert check_signature(signed, signers) == "ann@works"


def test_other_keys_no_signature_and_another_namespace_are_none(signed, key, tmp_path):
    new_key(tmp_path / "other")
    with pytest.raises(ExportError, match="no signature by"):
        check_signature(signed, tmp_path / "other.pub")
    signers = tmp_path / "allowed"
    signers.write_text(f"eve {(tmp_path / 'other.pub').read_text()}")
    with pytest.raises(ExportError, match="no signature by"):
        check_signature(signed, signers)
    (signed / "manifest.json.sig").unlink()
    command = ["ssh-keygen", "-Y", "sign", "-f", str(key), "-n", "git"]
    subprocess.run([*command, str(signed / "manifest.json")], check=True, capture_output=True)
    with pytest.raises(ExportError, match="no signature by"):
        check_signature(signed, tmp_path / "key.pub")
    (signed / "manifest.json.sig").unlink()
    with pytest.raises(ExportError, match=r"manifest\.json\.sig: missing"):
        check_signature(signed, tmp_path / "key.pub")


def forged(folder, rng):
    """Change something in an export, and compute every hash anew."""
    name = rng.choice(["a.txt", "b.txt", "manifest.json", "new.txt"])
    path = folder / name
    content = bytearray(path.read_bytes()) if path.exists() else bytearray(b"new")
    content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    path.write_bytes(content)
    if name in ("a.txt", "b.txt", "new.txt"):
        write_manifest(folder, rng.choice(["job", "jab"]), "run")


def count_found(signed, key, times):
    before = {path.name: path.read_bytes() for path in signed.iterdir()}
    rng, found = random.Random(3), 0
    for _ in range(times):
        forged(signed, rng)
        try:
            check_signature(signed, key)
            check_manifest(signed)
        except ExportError:
            found += 1
        for path in signed.iterdir():
            path.unlink()
        for name, content in before.items():
            (signed / name).write_bytes(content)
    return found


def test_random_forgeries_without_the_key_are_found(signed, tmp_path):
    assert count_found(signed, tmp_path / "key.pub", 40) == 40


@pytest.mark.slow
def test_ten_thousand_forgeries_without_the_key_are_found(signed, tmp_path):
    assert count_found(signed, tmp_path / "key.pub", 10_000) == 10_000


def test_what_cannot_sign_is_one_line(tmp_path, capsys):
    make(tmp_path / "e")
    (tmp_path / "no.key").write_text("nonsense")
    with pytest.raises(InputError, match=r"no\.key: cannot sign: "):
        sign_export(tmp_path / "e", tmp_path / "no.key")
    assert run_app(["sign", str(tmp_path / "e"), "--key", str(tmp_path / "none")]) == 2
    assert "none: no such file: expected a private key" in capsys.readouterr().err
    assert run_app(["sign", str(tmp_path / "nothing"), "--key", str(tmp_path / "no.key")]) == 2
    assert not (tmp_path / "e" / "manifest.json.sig").exists()


def test_a_changed_export_is_not_signed(tmp_path, key):
    make(tmp_path / "e")
    (tmp_path / "e" / "a.txt").write_text("changed")
    with pytest.raises(ExportError, match=r"a\.txt: changed"):
        sign_export(tmp_path / "e", key)


def test_a_new_export_has_no_signature_of_the_old_one(signed):
    make(signed, "new")
    assert not (signed / "manifest.json.sig").exists()
    assert json.loads((signed / "manifest.json").read_text())["files"].keys() == {"a.txt", "b.txt"}


def test_verify_with_a_key_says_what_is_wrong(signed, tmp_path, capsys):
    other = new_key(tmp_path / "other")
    assert run_app(["verify", str(signed), "--key", f"{other}.pub"]) == 4
    assert "no signature by" in capsys.readouterr().err
