"""The drawing of a stack names its layers, however many, and where they lie."""

from mpfcad.backlight import read_stack
from mpfcad.report.drawing.stack_drawing import draw_stack


def test_layers_of_all_kinds_are_drawn_and_named(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(
        'extends = "thesis-32in-mpf"\n'
        'layers = ["diffusing_plate", { kind = "plate", thickness_mm = 3 }, "film",\n'
        '{ kind = "bef", flipped = true }, { kind = "bef", rotation_deg = 90, pitch_um = 24 },\n'
        '{ kind = "sheet", sigma = 0.2 }]\n',
        encoding="utf-8",
    )
    picture = draw_stack(read_stack(path, overrides={"resin_scattering_per_mm": 4.0}))
    for words in (
        "diffusing plate", "n = 1.49, 3 mm", "resin scatters 4 /mm, g = 0", "prism film, upside",
        "prisms 24 × 25 µm, turned 90°", "σ = 0.2 of the direction",
    ):  # fmt: skip
        assert words in picture
    assert picture.count("matrix(1 0 0 -1") == 1
