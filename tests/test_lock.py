"""Continuous integration installs from a lock file: it has to hold what pyproject.toml asks for."""

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]


def locked():
    """Return the versions of the lock file by name, and how many have no hash."""
    text = (ROOT / ".ci/requirements.txt").read_text("utf-8")
    found = re.findall(r"^([\w.\-]+)==(\S+)( \\\n +--hash=sha256:[0-9a-f]{64})?", text, re.M)
    return {canonicalize_name(name): version for name, version, _ in found}, sum(
        not digest for *_, digest in found
    )


def test_every_dependency_is_locked_in_a_version_that_is_allowed_and_with_its_hash():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    asked = [*project["dependencies"], *project["optional-dependencies"]["test"]]
    versions, bare = locked()
    wrong = []
    for one in map(Requirement, asked):
        version = versions.get(canonicalize_name(one.name))
        if version is None or not one.specifier.contains(version):
            wrong.append(f"{one}: locked {version}")
    assert not wrong and not bare and len(versions) > len(asked)
