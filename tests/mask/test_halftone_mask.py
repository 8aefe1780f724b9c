"""The mask of a halftone: whole pieces of one ratio, nothing between them, read back by KLayout."""

from dataclasses import replace

import klayout.db as kdb
import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film import FieldFilm, Groove, HalftoneField, Process, build_halftone, read_process
from mpfcad.mask import MaskRules, build_mask, check_mask, write_mask
from mpfcad.mask.fabric import find_mesh
from mpfcad.mask.pattern.levelling import levelling_residual
from mpfcad.mask.screen.printing import find_printing
from mpfcad.mask.screen.slot_ripple import slot_ripple
from mpfcad.record.printing import PrintLimits, print_gates

BEF = Groove(0.050, 0.025)
PROCESS = read_process(None, BEF)
PRINTED, PIECE, PANEL = 60.0, 2.0, 21.3
RATIO = float(PROCESS.aperture_ratio_of_curvature(PRINTED))


def film(alike=4, n=48, panel_grooves=70):
    u, v = (np.arange(n) + 0.5) / n, (np.arange(6) + 0.5) / 6
    tone = 71 + 5 * np.cos(2 * np.pi * u)[:, None] + 3 * np.cos(2 * np.pi * v)
    halftone = build_halftone(BEF, PRINTED, tone, alike)
    place = (BEF.pitch, PIECE, 9, 3.1, panel_grooves, PANEL)
    field = HalftoneField(halftone.two_level, *place, halftone)
    return FieldFilm(BEF, PANEL, panel_grooves, field)


def rules(pattern="slot", period=0.4, **other):
    return MaskRules(pattern, period, 0.008, 0.010, **other)


def wanted_pieces(found):
    """Return y of each whole piece of the panel, and which grooves print it."""
    first = 3.1 - 2 * PIECE  # cut by the edge
    y = first + np.arange(1, 12) * PIECE
    y = y[(y >= 0) & (y + PIECE <= PANEL)]
    middle = y + PIECE / 2
    x = found.groove_position
    return y, found.curvature_at(x[:, None], middle[None]) < BEF.curvature_empty


@pytest.mark.parametrize("pattern", ["slot", "dot"])
def test_klayout_finds_the_ratio_in_printed_pieces_and_nothing_in_bare_ones(tmp_path, pattern):
    period = 0.4 if pattern == "slot" else 0.05
    one = film()
    mask = build_mask(one, PROCESS, rules(pattern, period), "job")
    write_mask(mask, tmp_path / "mask.oas")
    layout = kdb.Layout()
    layout.read(str(tmp_path / "mask.oas"))
    layer = layout.find_layer(1, 0)
    region = kdb.Region(layout.top_cell().begin_shapes_rec(layer)).merged()
    y, printed = wanted_pieces(one)
    assert 0.2 < printed.mean() < 0.8
    area = np.empty(printed.shape)
    for i, k in np.ndindex(*printed.shape):
        low = round(y[k] * 1e6)
        box = kdb.Box(i * 50_000, low, (i + 1) * 50_000, low + 2_000_000)
        area[i, k] = (region & kdb.Region(box)).area() / box.area()
    assert np.abs(area[printed] - RATIO).max() < 2e-4
    assert area[~printed].max() == 0
    whole = kdb.Region(kdb.Box(0, round(y[0] * 1e6), 70 * 50_000, round((y[-1] + 2) * 1e6)))
    assert (region - whole).is_empty()
    check = check_mask(tmp_path / "mask.oas", mask)
    assert check.aperture_ratio_error_max < 1e-4 and check.ratio_map_error_max < 1e-9
    assert mask.ratio_ends == (pytest.approx(RATIO),) * 2


def test_what_the_mask_tells_of_its_integral_is_what_it_draws():
    one = film()
    mask = build_mask(one, PROCESS, rules(), "job")
    y, printed = wanted_pieces(one)
    edge = np.append(y, y[-1] + PIECE)
    for integral in (mask.open_length, mask.wanted_length):
        mean = np.diff(integral(0, 70, edge), axis=1) / PIECE
        assert mean == pytest.approx(np.where(printed, RATIO, 0.0), abs=2e-5)
    assert mask.wanted_ratio == pytest.approx(mask.aperture_ratio, abs=2e-5)


def test_a_wanted_step_is_no_ripple_and_a_slot_s_ripple_is_seen():
    """The ripple is that of slots within a printed piece, whatever share is printed."""
    for period in (0.4, 1.0):
        mask = build_mask(film(), PROCESS, rules(period=period, levelling_length=0.8), "job")
        residual = levelling_residual(mask)
        assert residual.groove_ratio[residual.groove_ratio > 0] == pytest.approx(RATIO, rel=0.01)
        expected = float(slot_ripple(RATIO, mask.period, 0.8))
        # A piece's end is a cell's: that leaves up to 1 % in its last half millimetre.
        assert 0.7 * expected < residual.groove_rms.max() < 1.3 * expected + 0.01 * RATIO
    assert expected > 0.05 * RATIO


def test_a_shifted_print_is_judged_by_the_map_and_the_process_by_what_is_printed():
    mask = build_mask(film(), PROCESS, rules(), "job")
    found = find_printing(mask, PROCESS, 0.2, None)
    # 5 /mm over a cell of 48 grooves: 2π/2.4 · 5 · 0.2 at most.
    assert 1.5 < found.registration_curvature < 2 * np.pi / 2.4 * 5 * 0.2
    assert found.ratio_min == found.ratio_max == pytest.approx(RATIO)


def test_the_gates_of_a_screen_are_of_printed_pieces(tmp_path):
    """A groove that is printed over a tenth of its length has the ratio of its printed pieces."""
    mask = build_mask(film(), PROCESS, rules(mesh=find_mesh("165-27"), period=2.0), "job")
    write_mask(mask, tmp_path / "mask.oas")
    check = check_mask(tmp_path / "mask.oas", mask)
    limits = PrintLimits(0.05, 0.85, 10.0, 10.0, 10.0)
    found = find_printing(mask, PROCESS, 0.2, None)
    gates = {gate.name: gate for gate in print_gates(found, {"mask.oas": check}, limits)}
    assert gates["screen_ratio_min"].value == pytest.approx(RATIO, rel=1e-3)
    assert gates["screen_ratio_max"].value == pytest.approx(RATIO, rel=1e-3)
    assert check.aperture_ratio[check.aperture_ratio > 0].min() < 0.5 * RATIO
    thin = replace(check, aperture_ratio=check.aperture_ratio * 0.8)
    gates = {gate.name: gate for gate in print_gates(found, {"mask.oas": thin}, limits)}
    assert gates["screen_ratio_min"].value == pytest.approx(0.8 * RATIO, rel=1e-3)
    assert gates["screen_ratio_min"].outcome == "FAIL"


def test_what_a_screen_does_not_hold_is_refused():
    mesh = find_mesh("120-34")
    for pattern, alike, other, words in (
        ("slot", 1, {"mesh": mesh}, "halftone.grooves: 1: slots 50 µm wide .*expected 2 or more"),
        (
            "slot",
            4,
            {"mesh": mesh},
            "halftone.curvature_per_mm: 60: aperture_ratio 0.05932: expected 0.2",
        ),
        ("blue-noise", 4, {}, "mask.pattern: blue-noise: expected 'slot' or 'dot' for a halftone"),
    ):
        period = 0.4 if alike == 4 else 2.0
        with pytest.raises(InputError, match=words):
            build_mask(film(alike), PROCESS, rules(pattern, period, **other), "job")


def test_a_piece_that_the_process_does_not_fill_is_refused_by_its_table():
    weak = Process.build(BEF, "volume", [1.0], [0.04], "test")
    with pytest.raises(InputError, match=r"job: halftone: .*curvature_per_mm 60"):
        build_mask(film(), weak, rules(), "job")
