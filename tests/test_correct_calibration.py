"""`mpfcad correct --process`: coupons mean the same in the correction and in the job it writes."""

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.job import build_job, read_job
from mpfcad.pipeline.correct.next_job import write_job
from mpfcad.pipeline.correct.printed import _design
from mpfcad.pipeline.correct.resin import find_resin, printed_process, refuse_table
from mpfcad.pipeline.plan.plan import read_plan

TABLE = """schema = 1
kind = "table"
source = "coupons"
row = [
    { aperture_ratio = 0.1, curvature_per_mm = 68.0 },
    { aperture_ratio = 0.4, curvature_per_mm = 50.0 },
]
"""
TONE = """schema = 1
kind = "tone"
source = "coupons"
[tone]
transfer_factor = 0.6
dead_zone = 0.0
contrast = 1.0
gain = 1.0
deviation = [0.02, 0.001, 0.01, 0.01]
correlation = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
"""
SCREEN = '[screen]\nmesh = "150-31"\nvolume_cm3_m2 = 13.58\nsolids_fraction = {}\n'


class Found:
    """What a reprint says that the job's writer reads."""

    position = np.linspace(0, 1, 5)
    curvature = np.full(5, 65.0)


@pytest.fixture
def plan(tmp_path):
    document = {
        "name": "printed",
        "map": {"rows": [[0.0, 66.0], [8.0, 65.0], [16.345, 64.0]], "repeat": "mirror"},
        "process": {"solids_fraction": 0.5, "model": "prior"},
        "mask": {"mesh": {"name": "150-31", "release": 0.65}},
    }
    return read_plan(build_job(document, "printed"), tmp_path / "printed.toml")


@pytest.mark.parametrize("text", [TABLE, TONE, TONE + SCREEN.format(0.5), TONE + SCREEN.format(1)])
def test_the_next_job_reads_the_coupons_as_the_correction_did(tmp_path, plan, text):
    file = tmp_path / "coupons.toml"
    file.write_text(text)
    process = printed_process(plan, file)
    resin = find_resin(plan, _design(plan), file, file)
    assert resin.solids_for(plan) == 0.5
    out = tmp_path / "next"
    out.mkdir()
    write_job(out, plan, Found(), resin.document, file, None)
    path = out / "printed-corrected.toml"
    again = read_plan(read_job(path), path)
    ratio = np.linspace(0.05, 0.4, 9)
    assert np.array_equal(again.process.curvature(ratio), process.curvature(ratio))
    assert np.allclose(again.printed.curvature, 65.0, atol=0.5)


def test_coupons_of_undiluted_resin_are_scaled_to_the_prints(tmp_path, plan):
    found = []
    for solids in (0.5, 1):
        file = tmp_path / f"coupons-{solids}.toml"
        file.write_text(TONE + SCREEN.format(solids))
        found.append(float(printed_process(plan, file).fill_fraction(0.3)))
    # Half the resin dries out of a print of half the solids.
    assert found == pytest.approx([0.18, 0.09], rel=1e-3)


def test_thinner_resin_gives_less_of_it_through_the_same_apertures(tmp_path, plan):
    file = tmp_path / "coupons.toml"
    file.write_text(TONE + SCREEN.format(0.5))
    own = find_resin(plan, _design(plan), file, file)
    thin = find_resin(plan, _design(plan), file, file, 0.25)
    assert thin.process.fill_fraction(0.3) == pytest.approx(own.process.fill_fraction(0.3) / 2)
    assert thin.constraint.curvature_max > own.constraint.curvature_max
    out = tmp_path / "next"
    out.mkdir()
    write_job(out, plan, Found(), thin.document, file, None)
    path = out / "printed-corrected.toml"
    again = read_plan(read_job(path), path)
    assert again.job.process.solids_fraction == 0.25
    assert again.process.fill_fraction(0.3) == pytest.approx(thin.process.fill_fraction(0.3))


def test_a_table_says_nothing_of_other_resin(tmp_path, plan):
    file = tmp_path / "coupons.toml"
    file.write_text(TABLE)
    with pytest.raises(InputError, match="--solids: auto: expected to be left out with a table"):
        refuse_table(printed_process(plan, file), "auto")
