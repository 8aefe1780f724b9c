import re
import tomllib
from pathlib import Path

import pytest

from mpfcad.job import read_job

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text("utf-8")
COMMANDS = re.findall(r"```sh\n(.*?)\n```", README, re.DOTALL)


def test_readme_has_two_commands_of_one_line():
    assert len(COMMANDS) == 2
    assert all("\n" not in command for command in COMMANDS)
    assert "mpfcad run masks/patterned-16mm.toml" in COMMANDS[0]
    assert "pytest" in COMMANDS[1]


def test_ci_runs_exactly_the_commands_of_the_readme():
    lines = (ROOT / ".ci" / "run").read_text("utf-8").splitlines()
    assert [line for line in lines if line.startswith("python3 -m venv")] == COMMANDS
    assert "set -euo pipefail" in lines


def test_readme_states_the_python_that_the_package_needs():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    minimum = project["requires-python"].removeprefix(">=")
    assert f"Python {minimum} or newer" in README


def test_links_of_the_documents_lead_somewhere():
    for document in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        for target in re.findall(r"\]\(([^)#:]+)\)", document.read_text("utf-8")):
            assert (document.parent / target).exists(), f"{document.name}: {target}"


@pytest.mark.parametrize("name", ["uniform-c60", "patterned-16mm", "bef"])
def test_every_job_of_the_readme_is_there_and_valid(name):
    assert f"`{name}.toml`" in README
    job = read_job(ROOT / "masks" / f"{name}.toml")
    assert job.name == name


def test_job_document_names_every_field():
    text = (ROOT / "docs" / "job.md").read_text("utf-8")
    resolved = read_job(ROOT / "masks" / "bef.toml").document()
    for table, fields in resolved.items():
        for key in fields if isinstance(fields, dict) else [table]:
            assert key in text, key
