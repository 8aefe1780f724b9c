"""The code of the pages: commands are the program's, files are read, Python runs."""

import re
import shlex
import textwrap
import tomllib

import numpy as np
import pytest
import typer
from few_paths import few_paths
from page import NAMED, PAGES, blocks, write_files

from mpfcad.backlight import read_stack
from mpfcad.cli.app import app
from mpfcad.job import read_job
from mpfcad.job.design import read_design
from mpfcad.job.fit import read_fit

STACK_KEYS = {"extends", "title", "layers", "value", "source", "reflector"}


def of_language(*languages):
    return sorted(page for page in PAGES if {word for word, _ in blocks(page)} & {*languages})


@pytest.mark.parametrize("page", of_language("sh", ""))
def test_commands_are_those_of_the_program(page):
    group = typer.main.get_command(app)
    for _, text in blocks(page):
        for line in re.findall(r"^ *mpfcad .*$", text.replace("\\\n", " "), re.MULTILINE):
            _, name, *arguments = shlex.split(line, comments=True)
            group.commands[name].make_context(name, arguments)


@pytest.mark.parametrize("page", of_language("toml"))
def test_files_are_read_as_jobs_and_stacks(page, tmp_path):
    write_files(page, tmp_path)
    for language, text in blocks(page):
        if language != "toml":
            continue
        document, named = tomllib.loads(textwrap.dedent(text)), NAMED.match(text)
        if "measurement" in document:
            path = tmp_path / (named[1] if named else "fit.toml")
            path.write_text(text, "utf-8")
            assert read_fit(path).name == document["name"]
        elif "name" in document and "map" not in document:
            assert read_design(tmp_path / named[1]).name == document["name"]
        elif "name" in document:
            assert read_job(tmp_path / named[1]).name == document["name"]
        elif named:
            read_stack(tmp_path / named[1])
        elif document.keys() <= STACK_KEYS and not re.search(r'"[\w-]+\.[a-z]\w*"', text):
            part = tmp_path / "part.toml"
            base = "" if "extends" in document else 'extends = "thesis-32in-mpf"\n'
            part.write_text(base + textwrap.dedent(text), "utf-8")
            read_stack(part)


@pytest.mark.parametrize("page", of_language("python"))
def test_python_runs(page, tmp_path, monkeypatch, capsys):
    """As it stands there, but with fewer paths and a panel of three lamps, 8 mm apart."""
    for path in write_files(page, tmp_path):
        text = re.sub(r"(panel_width_mm) = .*", r"\1 = 24.0", path.read_text("utf-8"))
        text = re.sub(r"(panel_length_mm) = .*", r"\1 = 20.0", text)
        path.write_text(re.sub(r"(lamp_count) = .*", r"\1 = 3", text).replace("29.0", "8.0"))
    monkeypatch.chdir(tmp_path)
    names = {}
    with few_paths():
        for language, text in blocks(page):
            if language == "python":
                exec(compile(text.replace("29.0", "8.0"), f"{page}.md", "exec"), names)
    if "run" in names:
        inputs = {entry["name"]: entry["value"] for entry in names["run"].record["inputs"]}
        assert np.ptp(names["x"]) == inputs["stack.lamp_pitch_mm"]
        assert names["run"].report.is_file()
        assert str(names["run"].verdict) in capsys.readouterr().out
