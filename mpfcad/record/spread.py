"""Point spread functions of LEDs, and what zones do, in outside names and plain values."""

from typing import Any

import numpy as np

from mpfcad.measure.cell.block import BlockResult, Profile
from mpfcad.measure.cell.spread import SpreadResult, ratio_of
from mpfcad.record.measurement import describe_estimate

#: Cells on either side of an LED's own over which its map is stated.
_MAP_CELLS = 2
_SHARES = (0.5, 0.9)
_STANDARD = (
    "IEC 62595-2-1:2016, Measurement methods of block-wise BLUs: checkerboard, single block white, "
    "single block black, incoherent point spread function; docs/measure.md says what is taken"
)


def describe_spread(result: SpreadResult, block: BlockResult | None) -> dict[str, Any]:
    """Return what each LED of a cell adds to the luminance, and what the middle zone does."""
    document: dict[str, Any] = {
        "cell_mm": list(result.size),
        "leds": [_led(result, number) for number in range(len(result.position))],
        "beside_maps": {
            "share": float(result.beside.mean()),
            "cells": 2 * result.reach + 1,
        },
        "paths": int(result.paths),
    }
    if block is not None:
        document["block"] = _block(block)
    return document


def _led(result: SpreadResult, led: int) -> dict[str, Any]:
    value, error = result.map_of(led)
    bins, middle = result.bins, result.reach
    kept = slice((middle - _MAP_CELLS) * bins, (middle + _MAP_CELLS + 1) * bins)
    light = result.batch[:, led].sum(axis=(2, 4))
    whole = light.sum(axis=(1, 2)) / (1 - result.beside)
    share = result.share().mean(axis=0)[led]
    return {
        "position_mm": [float(place) for place in result.position[led]],
        "light_in_own_cell": describe_estimate(ratio_of(light[:, middle, middle], whole)),
        **{
            f"radius_of_{100 * part:.0f}_percent_mm": describe_estimate(result.radius(led, part))
            for part in _SHARES
        },
        "light_in_cells": np.round(share, 7).tolist(),
        "bin_mm": [size / bins for size in result.size],
        "luminance_cd_m2": value[kept, kept].tolist(),
        "standard_error_cd_m2": error[kept, kept].tolist(),
    }


def _block(block: BlockResult) -> dict[str, Any]:
    alone, all_lit = block.even
    left, right, bottom, top = (float(edge) for edge in block.edge)
    return {
        "from_to_mm": [[left, right], [bottom, top]],
        "leds": block.leds,
        "zones": block.zones,
        "halo_outside_over_inside": describe_estimate(block.halo),
        "single_block_white_over_all_white": describe_estimate(block.white),
        "single_block_black_over_all_white": describe_estimate(block.black),
        "single_block_white_over_black": describe_estimate(block.contrast),
        "checkerboard_white_over_black": describe_estimate(block.checkerboard),
        "single_block_min_over_max_9_points": describe_estimate(alone),
        "all_white_min_over_max_9_points": describe_estimate(all_lit),
        "profile_across": _profile(block.across),
        "profile_along": _profile(block.along),
        "source": _STANDARD,
    }


def _profile(profile: Profile) -> dict[str, Any]:
    return {
        "from_middle_mm": [round(float(place), 6) for place in profile.place],
        "luminance_cd_m2": profile.luminance.tolist(),
        "standard_error_cd_m2": profile.standard_error.tolist(),
    }
