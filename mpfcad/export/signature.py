"""Signatures of an export: ssh-keygen signs manifest.json, which holds the hash of every file.

The format is OpenSSH's (PROTOCOL.sshsig), the namespace `mpfcad-export`: a signature made for
something else is none of an export. Keys are those that a person has for ssh or git already.
"""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from mpfcad.boundary import TEXT_LIMIT, check_file
from mpfcad.errors import ExportError, InputError
from mpfcad.export.manifest import MANIFEST, SIGNATURE, check_manifest

_NAMESPACE = "mpfcad-export"
_SIGNER = "signer"
_PUBLIC = ("ssh-", "ecdsa-", "sk-ssh-", "sk-ecdsa-")
_TIMEOUT = 120.0


def sign_export(folder: Path, key: Path) -> Path:
    """Sign the manifest of an export with a private key; return the signature's file.

    Raises
    ------
    InputError
        when there is no such key or no ssh-keygen, or the key cannot sign.
    ExportError
        when a file of the export is not as its manifest states.
    """
    check_file(key, TEXT_LIMIT, "a private key as ssh-keygen makes it")
    check_manifest(folder)
    with tempfile.TemporaryDirectory() as temporary:
        copy = Path(temporary) / MANIFEST
        copy.write_bytes((folder / MANIFEST).read_bytes())
        # The passphrase is asked for by ssh-keygen itself, on the terminal.
        done = _ssh_keygen("-Y", "sign", "-f", str(key), "-n", _NAMESPACE, str(copy), quiet=False)
        made = Path(f"{copy}.sig")
        if done.returncode or not made.is_file():
            raise InputError(f"{key}: cannot sign: {_last(done)}: expected a private key of ssh")
        part = folder / f".{SIGNATURE}.{os.getpid()}"
        part.write_bytes(made.read_bytes())
        part.replace(folder / SIGNATURE)
    return folder / SIGNATURE


def check_signature(folder: Path, key: Path) -> str:
    """Return whose signature an export has: one by `key`, a public key or a list of signers.

    A list is an `allowed_signers` file of ssh-keygen. Only the manifest is looked at here; that the
    files are those of the manifest is `check_manifest`'s.

    Raises
    ------
    InputError
        when there is no such key or no ssh-keygen.
    ExportError
        when there is no signature, or none by that key over this manifest.
    """
    check_file(key, TEXT_LIMIT, "a public key or an allowed_signers file")
    signature = folder / SIGNATURE
    if signature.is_symlink() or not signature.is_file():
        raise ExportError(f"{signature}: missing: expected a signature (mpfcad sign)")
    text = key.read_bytes()
    with tempfile.TemporaryDirectory() as temporary:
        signers = Path(temporary) / "signers"
        public = text.lstrip().startswith(tuple(kind.encode() for kind in _PUBLIC))
        signers.write_bytes(f"{_SIGNER} ".encode() + text.strip() + b"\n" if public else text)
        names = [_SIGNER] if public else _principals(signers, signature)
        for name in names:
            with (folder / MANIFEST).open("rb") as manifest:
                done = _ssh_keygen(
                    "-Y", "verify", "-f", str(signers), "-I", name, "-n", _NAMESPACE, "-s",
                    str(signature.resolve()), stdin=manifest,
                )  # fmt: skip
            if done.returncode == 0:
                return str(key) if public else name
    raise ExportError(f"{signature}: no signature by {key} over this {MANIFEST}")


def _principals(signers: Path, signature: Path) -> list[str]:
    found = _ssh_keygen(
        "-Y", "find-principals", "-f", str(signers), "-s", str(signature.resolve())
    )  # fmt: skip
    return found.stdout.split() if found.returncode == 0 else []


def _ssh_keygen(
    *arguments: str, stdin: object = subprocess.DEVNULL, quiet: bool = True
) -> "subprocess.CompletedProcess[str]":
    program = shutil.which("ssh-keygen")
    if program is None:
        raise InputError("ssh-keygen: not found: expected OpenSSH 8.1 or newer on the PATH")
    source = None if not quiet else stdin
    try:
        return subprocess.run(
            [program, *arguments], stdin=source, capture_output=True, text=True,  # type: ignore[call-overload]
            errors="backslashreplace", timeout=_TIMEOUT, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise InputError(f"ssh-keygen: no answer within {_TIMEOUT:g} s") from None


def _last(done: "subprocess.CompletedProcess[str]") -> str:
    lines = (done.stderr or done.stdout).strip().splitlines()
    return lines[-1][:120] if lines else f"exit code {done.returncode}"
