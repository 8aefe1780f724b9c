"""What the plots of colour say beside their axes."""

from mpfcad.report.drawing.colour_figure import colour_cell_figure


def test_the_map_over_a_cell_says_what_its_colours_are():
    places = {"x_mm": [-1.0, -1.0, 1.0, 1.0], "y_mm": [-1.0, 1.0, -1.0, 1.0],
              "u_prime": [0.2, 0.201, 0.2, 0.2], "v_prime": [0.4, 0.4, 0.4, 0.403]}  # fmt: skip
    mean = {"u_prime": {"value": 0.2}, "v_prime": {"value": 0.4}}
    heat = colour_cell_figure({"over_screen": places, "mean": mean}).data[0]
    assert heat.colorbar.title.text == "Δu′v′ [0.001]"
    assert [[round(float(one), 3) for one in row] for row in heat.z] == [[0, 0], [1, 3]]
