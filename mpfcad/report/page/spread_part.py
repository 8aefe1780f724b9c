"""What pages show of point spread functions and zones."""

from typing import Any

from mpfcad.report.drawing.plot import plot
from mpfcad.report.drawing.spread_figure import block_figure, spread_figure

Record = dict[str, Any]
_BEYOND = "beside the maps"


def spread_values(found: Record) -> Record:
    """Return the figures of `describe_spread` for a page's part."""
    leds, block = found["leds"], found.get("block")
    rows = []
    for number, led in enumerate(leds, 1):
        name = "of an LED's light" if len(leds) == 1 else f"of LED {number}'s light"
        rows += [
            (f"share {name} that leaves in its own cell", led["light_in_own_cell"], 4, ""),
            (f"radius within which half {name} leaves [mm]",
             led["radius_of_50_percent_mm"], 4, _BEYOND),
            (f"radius within which 90 % {name} leaves [mm]",
             led["radius_of_90_percent_mm"], 4, _BEYOND),
        ]  # fmt: skip
    return {
        "map": plot(spread_figure(leds[0]), "spread"),
        "rows": rows,
        "paths": found["paths"],
        "beside_percent": f"{100 * found['beside_maps']['share']:.2g}",
        "cells": found["beside_maps"]["cells"],
        "block": None if block is None else _block(block),
    }


def _block(block: Record) -> Record:
    names = (
        ("halo: light outside over light inside, one zone white", "halo_outside_over_inside"),
        ("single block white: L in it / L while all are white",
         "single_block_white_over_all_white"),
        ("single block black: L in it / L while all are white",
         "single_block_black_over_all_white"),
        ("single block: white / black", "single_block_white_over_black"),
        ("checkerboard: L in a white block / in a black one", "checkerboard_white_over_black"),
        ("L_{min}/L_{max} on 9 points of the block, it alone white",
         "single_block_min_over_max_9_points"),
        ("L_{min}/L_{max} on 9 points of the block, all white",
         "all_white_min_over_max_9_points"),
    )  # fmt: skip
    sides = [high - low for low, high in block["from_to_mm"]]
    return {
        "plot": plot(block_figure(block), "block"),
        "rows": [(label, block[key], 4, "–") for label, key in names],
        "words": f"{block['zones']} zones; the middle one is {sides[0]:.4g} × {sides[1]:.4g} mm "
        f"and has {block['leds']} LED{'s' if block['leds'] > 1 else ''}",
        "source": block["source"],
    }
