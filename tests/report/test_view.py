"""`mpfcad view`: what the server hands out, and what it does not."""

import http.client
import json
import subprocess
import sys
import threading
from urllib.parse import quote, urlsplit

import pytest

from mpfcad.export import write_manifest
from mpfcad.report.view import ViewServer, find_exports
from mpfcad.report.view.gallery import comparison_page

CURVE = [1.0 + 0.001 * (i % 3) for i in range(33)]


def record(name, contrast):
    """Return as much of a verification.json as the gallery reads."""
    low, high = contrast - 0.001, contrast + 0.001
    estimate = {"value": contrast, "ci95": [low, high]}
    gate = {
        "name": "lamp_mura_contrast", "value": contrast, "ci95": [low, high], "limit": 0.012,
        "marginal_limit": 0.018, "outcome": "PASS" if high < 0.012 else "FAIL",
    }  # fmt: skip
    return {
        "name": name, "verdict": gate["outcome"], "gates": [gate], "lamp_mura_contrast": estimate,
        "mean_luminance_cd_m2": {"value": 7000.0, "ci95": [6990.0, 7010.0]},
        "relative_luminance": 1.02, "degrees_of_freedom": 30.0,
        "luminance": {
            "position_pitch": [i / 32 for i in range(33)],
            "luminance_cd_m2": [7000 * v for v in CURVE], "standard_error_cd_m2": [10.0] * 33,
        },
        "curve": {"luminance_cd_m2": [7000 * v for v in CURVE]},
        "inputs": [{"name": "map.curvature_per_mm", "value": contrast, "tag": "given"}],
    }  # fmt: skip


@pytest.fixture
def exports(tmp_path):
    root = tmp_path / "exports"
    for place, contrast in (("good", 0.004), ("deep/bad", 0.03)):
        folder = root / place
        folder.mkdir(parents=True)
        (folder / "verification.json").write_text(json.dumps(record(folder.name, contrast)))
        (folder / "report.html").write_text(f"<title>{folder.name}</title>")
        (folder / "mask.oas").write_bytes(b"oasis")
        write_manifest(folder, folder.name, "run")
    old = root / "old"
    old.mkdir()
    (old / "verification.json").write_text('{"verdict": "PASS"}')
    write_manifest(old, "old", "run")
    (root / "broken").mkdir()
    (root / "broken" / "manifest.json").write_text("{")
    (root / ".hidden").mkdir()
    (root / ".hidden" / "secret.txt").write_text("secret")
    (tmp_path / "outside.txt").write_text("outside")
    (root / "good" / "link.txt").symlink_to(tmp_path / "outside.txt")
    return root


@pytest.fixture
def server(exports):
    with ViewServer(exports) as made:
        thread = threading.Thread(target=made.serve_forever)
        thread.start()
        yield made
        made.shutdown()
        thread.join()


def get(server, path, method="GET", host=None):
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    connection.request(method, path, headers={"Host": host} if host else {})
    answer = connection.getresponse()
    return answer.status, answer.read(), dict(answer.getheaders())


def test_exports_are_found_by_place_and_broken_ones_left_out(exports):
    found = {one.place: (one.verdict, one.address) for one in find_exports(exports)}
    assert found == {
        "deep/bad": ("FAIL", "deep/bad/report.html"),
        "good": ("PASS", "good/report.html"),
        "old": ("PASS", "old/manifest.json"),
    }


def test_gallery_shows_every_verdict(server):
    status, content, headers = get(server, f"/{server.token}/")
    assert status == 200
    text = content.decode()
    for words in ('href="good/report.html"', "good</a>: PASS", "bad</a>: FAIL", "102.0 %"):
        assert words in text
    assert "connect-src" not in headers["Content-Security-Policy"]
    assert headers["Content-Security-Policy"].startswith("default-src 'none'")


def test_two_runs_beside_each_other(server):
    status, content, _ = get(server, f"/{server.token}/pair?run=good&run=deep/bad")
    assert status == 200
    for words in ("0.0040 [0.0030, 0.0050]", "0.0300 [0.0290, 0.0310]", "map.curvature_per_mm"):
        assert words in content.decode()
    for query in (
        "run=good",
        "run=good&run=none",
        "run=good&run=old",
        "run=good&run=good&run=good",
        "",
    ):
        assert get(server, f"/{server.token}/pair?{query}")[0] == 404


def test_files_are_shown_or_handed_over(server):
    status, content, headers = get(server, f"/{server.token}/good/report.html")
    assert (status, content) == (200, b"<title>good</title>")
    assert "Content-Disposition" not in headers
    status, content, headers = get(server, f"/{server.token}/good/mask.oas")
    assert (status, content) == (200, b"oasis")
    assert headers["Content-Disposition"] == 'attachment; filename="mask.oas"'
    assert get(server, f"/{server.token}/good/mask.oas", "HEAD")[:2] == (200, b"")


@pytest.mark.parametrize(
    "place",
    [
        "../outside.txt", "good/../../outside.txt", quote("../outside.txt", safe=""),
        "%2e%2e/outside.txt", "good/link.txt", ".hidden/secret.txt", "/etc/passwd", "good",
        "good/none.txt", "good/..%5c..%5coutside.txt", "good/%00",
    ],
)  # fmt: skip
def test_nothing_outside_is_handed_out(server, place):
    status, content, _ = get(server, f"/{server.token}/{place}")
    assert (status, content) == (404, b"not found\n")


def test_without_the_token_or_under_another_name_there_is_nothing(server):
    for path in ("/", "/good/report.html", "/wrong/", f"/{server.token[:-1]}/"):
        assert get(server, path)[0] == 404
    assert get(server, f"/{server.token}/", host="evil.example")[0] == 404
    assert get(server, f"/{server.token}/", host=f"localhost:{server.server_port}")[0] == 200
    assert get(server, f"/{server.token}/", "POST")[0] == 501
    assert server.server_address[0] == "127.0.0.1"


def test_tokens_differ(exports):
    with ViewServer(exports) as one, ViewServer(exports) as other:
        assert one.token != other.token
        assert len(one.token) >= 24


def test_command_prints_its_address_and_ends_with_ctrl_c(exports):
    import signal

    code = "from mpfcad.cli import main; main()"
    command = [sys.executable, "-c", code, "view", str(exports / "good"), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        address = urlsplit(process.stdout.readline().strip())
        connection = http.client.HTTPConnection(address.netloc, timeout=20)
        connection.request("GET", address.path + "report.html")
        assert connection.getresponse().read() == b"<title>good</title>"
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0


def test_a_run_under_leds_is_compared_with_another(tmp_path):
    """It has a cell in place of a pitch, and so no curve over the pitch."""
    for place in ("board", "tubes"):
        found = record(place, 0.004)
        if place == "board":
            del found["curve"]
            found["cell"] = {"across_mm": 4.0, "along_mm": 4.0}
            found["fit"] = {"order": [[0, 0], [1, 0]], "coefficient_cd_m2": [7000.0, 20.0]}
        (tmp_path / place).mkdir()
        (tmp_path / place / "verification.json").write_text(json.dumps(found))
        write_manifest(tmp_path / place, place, "run")
    page = comparison_page(tmp_path, ["board", "tubes"])
    assert page and "Seen from straight above" in page and page.count('id="plot-pitch"') == 1
    assert comparison_page(tmp_path, ["board", "board"]) is not None
    assert 'id="plot-pitch"' not in str(comparison_page(tmp_path, ["board", "board"]))
