"""The report in real browsers: every plot drawn, nothing from outside, nothing cut off.

The tests run in each browser that is installed (Firefox: `pytest -m slow`).
`test_a_browser_is_here` warns where none is.
"""

import importlib.util
import json
import re
import unicodedata
import warnings
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from browser import here
from pypdf import PdfReader

from mpfcad.errors import InputError
from mpfcad.job import read_job
from mpfcad.measure import rounds
from mpfcad.pipeline import TRACE_SETTINGS, TraceSetting, run_job
from mpfcad.report.browser import write_pdf

PLOTS = (
    "luminance", "film", "levelling", "grooves", "directions", "cuts", "paths", "facets",
    "response",
)  # fmt: skip
#: Phone to 4K; the middle ones are among the slow tests.
WIDTHS = (390, *(pytest.param(w, marks=pytest.mark.slow) for w in (768, 1920)), 1200, 3840)
#: Pages of paper that the export below takes at most (A4 12, Letter 14), and room for other fonts.
PAGES = 15
A4, LETTER = (8.27, 11.69), (8.5, 11.0)
OVERFLOWING = """
[...document.querySelectorAll('main *')].filter(e => !e.closest('.scroll, .plot, svg, option')
  && getComputedStyle(e).position !== 'absolute'
  && e.getBoundingClientRect().right > document.documentElement.clientWidth + 1)
  .map(e => e.tagName + ': ' + e.textContent.slice(0, 60))
"""
SCROLLING = """
[...document.querySelectorAll('main .scroll, main figure')].filter(e => e.getClientRects().length)
  .map(e => [e.textContent.slice(0, 40), e.scrollWidth > e.clientWidth
    && getComputedStyle(e).overflowX === 'auto', e.tabIndex === 0 && !!e.ariaLabel])
"""
#: Contrast of text with what lies behind it (WCAG 2.2, 1.4.3), the least over the page.
CONTRAST = """
(() => {
  const part = c => { c /= 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
  const light = ([r, g, b]) => 0.2126 * part(r) + 0.7152 * part(g) + 0.0722 * part(b);
  const read = text => text.match(/[\\d.]+/g).map(Number);
  const behind = e => {
    for (; e; e = e.parentElement) {
      const c = read(getComputedStyle(e).backgroundColor);
      if (c.length === 3 || c[3] === 1) return c.slice(0, 3);
    }
    return [255, 255, 255];
  };
  const words = e => [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
  return [...document.querySelectorAll('main *')]
    .filter(e => words(e) && !e.closest('svg, .plot, script, style') && e.getClientRects().length)
    .map(e => {
      const [a, b] = [light(read(getComputedStyle(e).color)), light(behind(e))];
      return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), e.textContent.slice(0, 40)];
    }).sort((a, b) => a[0] - b[0])[0];
})()
"""
#: Rules of WCAG 2.1, A and AA, and of good practice, that an automatic checker can tell.
AXE = Path(importlib.util.find_spec("axe_core_python").origin).with_name("axe.min.js")
AXE_RUN = """
axe.run(document, {runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"]})
  .then(found => found.violations.map(one => [one.id, one.nodes.map(node => node.html)]))
"""
#: Legends that lie on the title of an axis or on its numbers.
COVERED = """
[...document.querySelectorAll('.plot')].flatMap(plot => {
  const rects = sign => [...plot.querySelectorAll(sign)].map(e => e.getBoundingClientRect())
    .filter(r => r.width && r.height);
  const meets = (a, b) => a.left < b.right - 1 && b.left < a.right - 1
    && a.top < b.bottom - 1 && b.top < a.bottom - 1;
  const words = rects('.xtitle, .ytitle, .xtick, .ytick');
  return rects('.legend').some(a => words.some(b => meets(a, b))) ? [plot.id] : [];
})
"""
TITLED = "document.querySelectorAll('.plot .legend').length"
#: What moves or opens, and a ring around what is focused.
STOPS = "[...document.querySelectorAll('main a, summary, button, input, canvas[tabindex]')]"
FOCUSED = (
    STOPS
    + """.map((e, i) => e === document.activeElement
  && parseFloat(getComputedStyle(e).outlineWidth) >= 2 ? i : -1).filter(i => i >= 0)
"""
)


@pytest.fixture(scope="module")
def export(tmp_path_factory):
    """Make an export of a narrow panel with a short trace."""
    folder = tmp_path_factory.mktemp("browser")
    (folder / "small.toml").write_text(
        'extends = "thesis-32in-mpf"\n[value]\npanel_width_mm = 40.0\npanel_length_mm = 50.0\n'
        "lamp_count = 5\nlamp_pitch_mm = 8.0\n"
    )
    job = folder / "job.toml"
    job.write_text(
        'name = "a-film-whose-name-is-so-long-that-a-phone-has-to-break-its-line"\n'
        "[map]\ncurvature_per_mm = 60.0\n[cad]\nlength_mm = 0.5\n[stack]\nfile = 'small.toml'\n"
        "[process]\nsolids_fraction = 0.5\n[mask]\nmesh = '150-31'\nperiod_um = 560.0\n"
    )
    out = folder / "out"
    with pytest.MonkeyPatch.context() as patch:
        # One short round, under a limit that leaves room for the directions.
        patch.setattr(rounds, "LEAST_PATHS", 60_000)
        patch.setitem(TRACE_SETTINGS, "quick", TraceSetting(1.0, 660_000))
        run_job(read_job(job), job, out, effort="quick", threads=1)
    return out


def test_a_browser_is_here():
    if not here():
        warnings.warn(
            "no browser: the report's pages are not looked at; "
            "apt-get install chromium firefox-esr",
            stacklevel=1,
        )
    assert set(here()) <= {"chromium", "firefox"}


def _params():
    """Firefox takes twice as long to start as all tests take in Chromium."""
    marks = {"firefox": pytest.mark.slow}
    return [pytest.param(name, marks=marks.get(name, ())) for name in here()]


@pytest.fixture(scope="module", params=_params())
def browser(request):
    found = here()[request.param]()
    yield found
    found.close()


@pytest.fixture(scope="module")
def page(browser, export):
    browser.open((export / "report.html").as_uri())
    return browser


def test_every_plot_is_drawn_when_all_is_unfolded(page):
    page.run("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    page.wait("[...document.querySelectorAll('.plot')].every(p => p.querySelector('svg, canvas'))")
    found = page.run("[...document.querySelectorAll('.plot')].map(p => p.id.slice(5)).sort()")
    assert found == sorted(PLOTS)
    assert page.errors == []


def test_nothing_is_asked_of_a_network(page):
    assert page.requests
    assert {address.split(":")[0] for address in page.requests} <= {"file", "data", "about", "blob"}


def test_figures_are_those_of_the_record(page, export):
    record = json.loads((export / "verification.json").read_text())
    text = page.run("document.querySelector('#decision').innerText")
    contrast, mean = record["lamp_mura_contrast"], record["mean_luminance_cd_m2"]["value"]
    low, high = contrast["ci95"]
    assert record["verdict"] in text
    for words in (
        f"{contrast['value']:.4f} [{low:.4f}, {high:.4f}]",
        f"{mean:.0f} cd/m²",
        f"{record['relative_luminance'] * 100:.1f} %",
        f"eye's threshold {record['eye']['threshold_contrast']:.4f}",
        f"{record['plain']['lamp_mura_contrast']['value']:.4f}",
    ):
        assert words in text
    shown = page.run(
        "[...document.querySelectorAll('#gate tr')].map(row => row.lastElementChild.innerText)"
    )
    assert shown[1:] == [gate["outcome"] for gate in record["gates"]]
    drawn = page.run("document.querySelector('#plot-luminance').data[2].y.length")
    assert drawn == len(record["luminance"]["position_pitch"])


def drawn(page, name, number, axis="y"):
    """Return the numbers of a plot's trace."""
    return page.run(f"[...document.querySelector('#plot-{name}').data[{number}].{axis}]")


def test_plots_hold_the_numbers_of_the_record(page, export):
    record = json.loads((export / "verification.json").read_text())
    rounds = record["convergence"]
    assert drawn(page, "paths", 1) == pytest.approx(rounds["contrast"], abs=1e-6)
    assert rounds["contrast"][-1] == record["lamp_mura_contrast"]["value"]
    cut = record["directions"]["cut"]
    for number, plane in enumerate(("across", "along")):
        assert drawn(page, "cuts", number, "x") == cut[plane]["angle_deg"]
        assert drawn(page, "cuts", number) == pytest.approx(cut[plane]["luminance_cd_m2"], abs=0.01)
    middle = page.run("document.querySelector('#plot-directions').data[0].z[80][80]")
    assert middle == pytest.approx(record["directions"]["map"]["luminance_cd_m2"][0][0], abs=0.06)
    assert drawn(page, "film", 0) == pytest.approx(record["mask"]["curvature"]["wanted_per_mm"])
    ratio = record["mask"]["files"]["mask.oas"]["aperture_ratio_max"]
    assert max(drawn(page, "film", 4)) == pytest.approx(100 * ratio, abs=1e-3)
    facets = [row["facets_per_groove"] for row in record["facets"]]
    assert drawn(page, "facets", 0, "x") == pytest.approx(facets, abs=0.01)


#: Share of the mask's pixels that is open, over the panel, as the viewer of the page draws it.
OPEN_SHARE = """
(() => {
  const canvas = document.querySelector('.zoom canvas'), {width, height} = canvas;
  const pixels = canvas.getContext('2d').getImageData(0, 0, width, height).data;
  let open = 0, count = 0;
  for (let j = Math.round(0.2 * height); j < 0.7 * height; j++)
    for (let i = Math.round(0.45 * width); i < 0.55 * width; i++, count++)
      open += (255 - pixels[4 * (j * width + i)]) / 244;
  return open / count;
})()
"""


def test_the_mask_is_drawn_from_panel_to_aperture(page, export):
    record = json.loads((export / "verification.json").read_text())
    page.run("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    words = "document.querySelector('.zoom output').textContent"
    page.wait(f"{words}.startsWith('Shown')")
    whole = page.run(words)
    ratio = record["mask"]["files"]["mask.oas"]["aperture_ratio_max"]
    # A pixel holds 8 bits of it.
    assert page.run(OPEN_SHARE) == pytest.approx(ratio, abs=0.004)
    page.run("document.querySelector('.zoom button[name=aperture]').click()")
    page.wait(f"{words} !== {json.dumps(whole)}")
    near = page.run(words)
    assert "mm across" not in near
    across, along = (float(found) for found in re.findall(r"([\d.]+) µm", near))
    slot = ratio * 50_000 / round(50_000 / 560)  # of whole periods in the panel's length [µm]
    assert min(across, along) == pytest.approx(2 * slot, rel=1e-3)
    assert page.run(OPEN_SHARE) > 0.2
    page.run(
        "document.querySelector('.zoom canvas').dispatchEvent("
        "new KeyboardEvent('keydown', {key: '0', cancelable: true}))"
    )
    page.wait(f"{words} === {json.dumps(whole)}")
    assert page.errors == []


def test_a_slider_gives_the_curve_of_the_traced_effect(page, export):
    record = json.loads((export / "verification.json").read_text())
    one = record["printed"]["inputs"][0]
    page.run(
        "(slider => { slider.value = 1; slider.dispatchEvent(new Event('input')); })"
        "(document.querySelector('.sliders input'))"
    )
    u = np.linspace(0, 1, 129)
    curve = np.interp(u, np.linspace(0, 1, 33), record["curve"]["luminance_cd_m2"])
    curve /= curve[:-1].mean()
    for values in (one["effect_of_sigma"], one["second_order"]):
        for h in range(len(values) // 2):
            angle = 2 * np.pi * (h + 1) * u
            curve += values[2 * h] * np.cos(angle) + values[2 * h + 1] * np.sin(angle)
    contrast = (curve.max() - curve.min()) / (curve.max() + curve.min())
    assert f"{contrast:.4f} as set" in page.run(
        "document.querySelector('.sliders output').innerText"
    )
    page.run("document.querySelector('.sliders button').click()")
    assert page.run("document.querySelector('.sliders input').value") == "0"


def test_parts_have_names_and_places(page):
    """Landmark, ids that are one only, and words for everything that takes the keyboard."""
    assert page.run("document.querySelectorAll('main').length") == 1
    assert page.run("(all => all.length - new Set(all).size)([...document.querySelectorAll('[id]')]"
                    ".filter(e => !e.closest('.plot, svg')).map(e => e.id))") == 0  # fmt: skip
    nameless = """
    [...document.querySelectorAll('button, input, canvas, a, summary')].filter(e =>
      !e.closest('.plot') && !(e.ariaLabel || e.textContent.trim()
        || e.labels?.[0]?.textContent.trim()))
      .map(e => e.outerHTML)
    """
    assert page.run(nameless) == []
    assert page.run("[...document.querySelectorAll('[tabindex]')].every(e => e.tabIndex === 0)")


def test_what_scrolls_sideways_takes_the_keyboard_and_nothing_else(page):
    """WCAG 2.2, 2.1.1; a stop of the tabulator on what does not scroll leads nowhere."""
    page.run("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    for width in (390, 3840):
        page.width(width)
        page.run("new Promise(done => requestAnimationFrame(() => setTimeout(done, 200)))")
        found = page.run(SCROLLING)
        assert all(wide == reached for _, wide, reached in found), found
        assert any(wide for _, wide, _ in found) == (width == 390)


@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_runs_out_of_the_page(page, width):
    page.width(width)
    page.run("new Promise(done => requestAnimationFrame(() => setTimeout(done, 50)))")
    assert page.run("document.documentElement.scrollWidth") <= width
    assert page.run(OVERFLOWING) == []


def test_every_picture_and_plot_has_words(page):
    assert page.run("[...document.images].filter(i => !i.alt).length") == 0
    assert page.run("[...document.querySelectorAll('.plot')].filter(p => !p.ariaLabel).length") == 0
    assert page.run("document.documentElement.lang") == "en"
    levels = page.run("[...document.querySelectorAll('h1,h2,h3')].map(h => +h.tagName[1])")
    assert levels[0] == 1
    assert all(b - a <= 1 for a, b in pairwise(levels))


@pytest.fixture(scope="module")
def unfolded(browser, export):
    """Return what shows the report with all its parts open: again only where something else is."""

    def show(width, dark=False):
        if browser.showing != (width, dark):
            browser.open((export / "report.html").as_uri(), width, dark)
            browser.run(
                "document.querySelectorAll('details').forEach(part => { part.open = true; })"
            )
            browser.showing = (width, dark)
        return browser

    return show


def test_text_stands_out_from_its_ground(unfolded):
    page = unfolded(1200)
    for dark in (False, True):
        page.scheme(dark)
        ratio, words = page.run(CONTRAST)
        assert ratio >= 4.5, words
    page.scheme(False)


def test_the_tabulator_reaches_all_that_moves_and_shows_where_it_is(unfolded):
    page = unfolded(1200)
    count = page.run(f"{STOPS}.length")
    reached = []
    for _ in range(count):
        page.tab()
        reached += page.run(FOCUSED)
    assert reached == list(range(count))


@pytest.mark.parametrize("width", [1200, 390])
def test_a_legend_lies_on_no_axis(unfolded, width):
    page = unfolded(width)
    page.wait("[...document.querySelectorAll('.plot')].every(p => p.querySelector('svg'))")
    assert page.run(TITLED) >= 5
    assert page.run(COVERED) == []
    page.run("dispatchEvent(new Event('beforeprint'))")
    page.showing = None
    assert page.run(COVERED) == []


@pytest.mark.parametrize(
    ("width", "dark"),
    [(390, False), *(pytest.param(1200, dark, marks=pytest.mark.slow) for dark in (False, True))],
)
def test_a_checker_of_accessibility_finds_nothing(unfolded, width, dark):
    """axe-core: names, roles, headings, landmarks, contrast, targets of the keyboard."""
    page = unfolded(width, dark)
    page.run(f"(() => {{ {AXE.read_text('utf-8')} }})() ?? 0")
    assert page.run(AXE_RUN) == []


def test_a_film_is_looked_at_from_farther_off_on_a_phone(browser, export):
    """Also where the page was wide before: a phone is turned."""
    browser.open((export / "report.html").as_uri() + "#cad")
    scene = "document.querySelector('#plot-grooves')._fullLayout?.scene"
    browser.wait(f"!!{scene}")
    away = "(({x, y, z}) => Math.hypot(x, y, z))" + f"({scene}.camera.eye)"
    wide = browser.run(away)
    browser.width(390)
    browser.wait(f"{away} > {1.3 * wide}")


def test_a_page_whose_width_changes_draws_on(browser, export):
    browser.errors.clear()
    browser.open((export / "report.html").as_uri())
    browser.run("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    for width in (390, 1200):
        browser.width(width)
        browser.run("new Promise(done => setTimeout(done, 400))")
    assert browser.errors == []


@pytest.mark.parametrize("paper", [A4, pytest.param(LETTER, marks=pytest.mark.slow)])
def test_a_printed_page_shows_the_whole_verdict(browser, export, paper):
    browser.open((export / "report.html").as_uri())
    (export.parent / "page.pdf").write_bytes(browser.print(*paper))
    printed = PdfReader(export.parent / "page.pdf")
    record = json.loads((export / "verification.json").read_text())
    assert len(printed.pages) <= PAGES
    # A font may join f and i to one sign.
    first = unicodedata.normalize("NFKC", re.sub(r"\s+", " ", printed.pages[0].extract_text()))
    sentence = browser.run("document.querySelector('.banner p').innerText")
    assert record["verdict"] in first
    assert re.sub(r"\s+", "", sentence) in first.replace(" ", "")
    everything = "".join(page.extract_text() for page in printed.pages)
    assert record["provenance"]["sha256"]["film.stl"] in re.sub(r"\s+", "", everything)


def test_the_page_is_small(export):
    assert (export / "report.html").stat().st_size < 8e6


def test_pdf_has_no_date_and_lies_on_a4(export, tmp_path):
    from browser import CHROMIUM

    if not CHROMIUM:
        assert "chromium" not in here()
        return
    write_pdf(export / "report.html", tmp_path / "report.pdf", CHROMIUM)
    printed = PdfReader(tmp_path / "report.pdf")
    assert printed.metadata.creation_date.year == 2000
    width, height = (float(side) * 25.4 / 72 for side in printed.pages[0].mediabox[2:])
    assert (round(width), round(height)) == (210, 297)


def test_without_a_chromium_pdf_is_refused_before_any_work(monkeypatch, tmp_path):
    monkeypatch.setenv("MPFCAD_BROWSER", "no-such-browser")
    job = tmp_path / "job.toml"
    job.write_text('name = "x"\n[map]\ncurvature_per_mm = 60.0\n')
    with pytest.raises(InputError, match="--pdf: no Chromium found: expected one of MPFCAD"):
        run_job(read_job(job), job, tmp_path / "out", pdf=True)
    assert not (tmp_path / "out").exists()
