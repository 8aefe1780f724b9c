"""What a mask needs is said before it is built, and refused where it is not there."""

import re

import numpy as np
import pytest
from small_mask import BEF, PROCESS, build

from mpfcad.cli import run_app
from mpfcad.errors import InputError
from mpfcad.film import CurvatureField, FieldFilm
from mpfcad.mask import MaskRules, build_mask, write_mask
from mpfcad.pipeline.plan.printed import mask_need as module
from mpfcad.pipeline.plan.printed.mask_need import film_need, mask_need, refuse_mask_need

SLOT = MaskRules("slot", 0.640, 0.015, 0.015)
RULES = {
    "slot": SLOT,
    "dot": MaskRules("dot", 0.050, 0.009, 0.010),
    "error-diffused": MaskRules("error-diffused", 0.050, 0.009, 0.010),
    "blue-noise": MaskRules("blue-noise", 0.050, 0.009, 0.010),
}


def film(width, length, nodes=30):
    x, y = np.linspace(0, width, nodes), np.linspace(0, length, nodes)
    wave = np.cos(2 * np.pi * x / 7) * np.cos(2 * np.pi * y[:, None] / 5)
    return FieldFilm(BEF, length, round(width / BEF.pitch), CurvatureField(x, y, 60 + 3 * wave))


@pytest.mark.parametrize("pattern", RULES)
def test_what_is_said_is_never_less_than_what_comes(tmp_path, pattern):
    panel = film(3.0, 4.0)
    mask = build_mask(panel, PROCESS, RULES[pattern], "job")
    before = film_need(panel, PROCESS, RULES[pattern], ["oas", "gds"], "job")
    after = mask_need(mask, ["oas", "gds"])
    assert before.apertures >= 0.999 * mask.aperture_count == 0.999 * after.apertures
    for suffix in ("oas", "gds"):
        write_mask(mask, tmp_path / f"mask.{suffix}")
        size = (tmp_path / f"mask.{suffix}").stat().st_size
        # Furniture and text are the same for every panel.
        assert size < mask_need(mask, [suffix]).disk_mb * 1e6 + 250_000


def test_a_lattice_takes_no_memory_an_aperture():
    need = mask_need(build(), ["oas", "gds", "dxf"])
    assert need.memory_gb == pytest.approx(0.5, abs=0.01) and need.minutes < 0.01


def test_the_two_large_panels_that_were_measured():
    """65 inch of slots: 35.9 million, 1.94 GB and 47 s; 10⁸ cells of dots are let through."""
    large = film_need(film(803.5, 1428.5), PROCESS, SLOT, ["oas"], "job")
    assert large.apertures == pytest.approx(35.87e6, rel=1e-3)
    assert 1.94 < large.memory_gb < 4 and 47 / 60 < large.minutes < 2
    cells = film_need(film(392.26, 697.68), PROCESS, RULES["dot"], ["oas"], "job")
    assert cells.apertures == pytest.approx(1.095e8, rel=1e-2)
    assert 4 < cells.memory_gb < 10 and 830 < cells.disk_mb < 1200


@pytest.mark.parametrize(("memory", "longest"), [(2.0, 4.0), (100.0, 0.01)])
def test_what_does_not_fit_is_refused_with_a_period_that_does(monkeypatch, memory, longest):
    monkeypatch.setattr(module, "available_memory", lambda: memory)
    monkeypatch.setattr(module, "LONGEST", longest)
    panel = film(803.5, 1428.5)
    with pytest.raises(InputError, match=r"job.toml: mask.period_um: 640: up to 35.87 ") as told:
        refuse_mask_need(panel, PROCESS, SLOT, ["oas"], "job.toml")
    assert len(str(told.value)) < 290
    least = float(re.search(r"at least ([\d.]+), or", str(told.value))[1]) / 1000
    refuse_mask_need(panel, PROCESS, MaskRules("slot", 1.01 * least, 0.01, 0.01), ["oas"], "job")
    with pytest.raises(InputError):
        refuse_mask_need(panel, PROCESS, MaskRules("slot", 0.9 * least, 0.01, 0.01), ["oas"], "j")


def test_the_command_says_it_and_refuses_it_before_it_builds(tmp_path, monkeypatch, capsys):
    job, out = tmp_path / "job.toml", tmp_path / "out"
    job.write_text('name = "a"\n[map]\ncurvature_per_mm = 60.0\n')
    assert run_app(["mask", str(job), "--plan"]) == 0
    assert re.search(r"the files take up to [\d.]+ MB, 0\.51? GB of memory", capsys.readouterr()[0])
    monkeypatch.setattr(module, "available_memory", lambda: 0.1)
    monkeypatch.setattr("mpfcad.mask.build_mask", lambda *given: pytest.fail("it was built"))
    assert run_app(["mask", str(job), "--out", str(out)]) == 2
    (line,) = [x for x in capsys.readouterr().err.splitlines() if x.startswith("mpfcad: ")]
    assert "job.toml: mask.period_um: " in line and "a smaller panel" in line and len(line) <= 300
    assert not out.exists()


def test_formats_that_are_not_asked_for_do_not_count(tmp_path, monkeypatch):
    """GDSII lists what OASIS need not: only what is written is refused."""
    asked = []
    monkeypatch.setattr(
        "mpfcad.pipeline.run.make.refuse_mask_need",
        lambda film, process, rules, formats, where: asked.append(tuple(formats)),
    )
    job = tmp_path / "job.toml"
    job.write_text('name = "a"\n[map]\ncurvature_per_mm = 60.0\n[mask]\nformats = ["gds"]\n')
    assert run_app(["mask", str(job), "--plan"]) == 0
    assert asked == [("oas",)]


def test_a_full_disk_is_seen_before_work(tmp_path, monkeypatch, capsys):
    job = tmp_path / "job.toml"
    job.write_text('name = "a"\n[map]\ncurvature_per_mm = 60.0\n')
    usage = module.shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(module.shutil, "disk_usage", lambda path: usage)
    assert run_app(["mask", str(job), "--out", str(tmp_path / "out")]) == 2
    assert "job.toml: mask.formats: the files take up to" in capsys.readouterr().err
