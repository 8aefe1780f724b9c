"""`mpfcad rays`, from outside."""

import json

import numpy as np
import pytest
from command import called, refused

from mpfcad.backlight.source.ray_file import read_rays
from mpfcad.cli import run_app


def output(capsys, *arguments):
    assert run_app([*map(str, arguments)]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(("form", "at"), [(".tm25ray", "screen"), (".dat", "film")])
def test_a_ray_file_holds_what_is_said(tmp_path, capsys, form, at):
    path = tmp_path / "deep" / f"light{form}"
    ask = ["rays", "thesis-32in-mpf", "--at", at, "--rays", 3000, "--json", "--out"]
    said = output(capsys, *ask, path, "--threads", 1)
    assert said["rays"] == 3000 and said["unit"] == "mm" and said["at"] == at
    ray = read_rays("x", path)
    assert ray.shape == (3000, 7)
    assert ray[:, 6].sum() == pytest.approx(said["flux_lm"]["value"], rel=1e-6)
    assert said["flux_lm"]["value"] < said["emitted_lm"] * (1 if at == "screen" else 3)
    again = output(capsys, *ask, tmp_path / f"again{form}", "--threads", 2)
    assert again["sha256"] == said["sha256"]
    assert (tmp_path / f"again{form}").read_bytes() == path.read_bytes()
    assert sorted(p.name for p in path.parent.iterdir()) == [path.name]
    other = output(capsys, *ask, path, "--seed", 2)
    assert other["sha256"] != said["sha256"]
    low, high = said["flux_lm"]["ci95"]
    assert abs(other["flux_lm"]["value"] - said["flux_lm"]["value"]) < 2 * (high - low)


def test_light_at_the_film_is_more_than_what_leaves(tmp_path, capsys):
    # What the film returns comes up to it again.
    found = {
        at: output(
            capsys, "rays", "thesis-32in-mpf", "--at", at, "--rays", 4000, "--json",
            "--out", tmp_path / "a.ray",
        )["flux_lm"]["value"]
        for at in ("screen", "film")
    }  # fmt: skip
    assert found["film"] > 1.3 * found["screen"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["thesis-32in-mpf", "--out", "a.ies"], ["--out: a.ies", ".tm25ray", ".dat", ".ray"]),
        (["thesis-32in-mpf", "--out", "folder.dat"], ["--out: folder.dat", "expected a file"]),
        (["no-such", "--out", "a.dat"], ["no-such"]),
        (
            ["thesis-32in-mpf", "--stack", "thesis-32in-bef", "--out", "a.dat"],
            ["--stack: thesis-32in-bef", "is a stack itself"],
        ),
        (["thesis-32in-mpf", "--offset-mm", "1", "--out", "a.dat"], ["--offset-mm: 1", "a mesh"]),
        (["thesis-32in-mpf-plate", "--at", "film", "--out", "a.dat"], ["bonded on a plate"]),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(tmp_path, arguments, words):
    (tmp_path / "folder.dat").mkdir()
    refused(called("rays", *arguments, cwd=tmp_path), *words)
    assert [p.name for p in tmp_path.iterdir()] == ["folder.dat"]


def test_rays_at_the_film_go_up_into_air(tmp_path, capsys):
    output(
        capsys, "rays", "thesis-32in-conventional", "--at", "film", "--rays", 2000, "--json",
        "--out", tmp_path / "a.ray",
    )  # fmt: skip
    ray = read_rays("x", tmp_path / "a.ray")
    assert (ray[:, 5] > 0).all() and np.abs(ray[:, 2]).max() == 0
