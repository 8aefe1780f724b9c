"""The export folder: it appears whole or not at all, with a manifest of every file's hash."""

from mpfcad.export.folder import export_folder, refuse_foreign
from mpfcad.export.manifest import MANIFEST, check_manifest, write_manifest
from mpfcad.export.text import canonical_json, sha256, write_text

__all__ = [
    "MANIFEST",
    "canonical_json",
    "check_manifest",
    "export_folder",
    "refuse_foreign",
    "sha256",
    "write_manifest",
    "write_text",
]
