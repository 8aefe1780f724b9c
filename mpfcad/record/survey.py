"""The luminance over direction that every run looks at, in outside names."""

from typing import Any

from numpy.typing import NDArray

from mpfcad.measure import Survey
from mpfcad.measure.angle.survey import AZIMUTH, CUT, POLAR
from mpfcad.units import deg


def describe_survey(survey: Survey) -> dict[str, Any]:
    """Return the map, a row a polar angle, and both cuts."""
    return {
        "map": {
            "polar_deg": _degrees(POLAR),
            "azimuth_deg": _degrees(AZIMUTH),
            "luminance_cd_m2": survey.luminance.tolist(),
            "standard_error_cd_m2": survey.standard_error.tolist(),
        },
        "cut": {
            name: {
                "angle_deg": _degrees(CUT),
                "luminance_cd_m2": found[:, 0].tolist(),
                "standard_error_cd_m2": found[:, 1].tolist(),
                "degrees_of_freedom": survey.freedom,
            }
            for name, found in (("across", survey.across), ("along", survey.along))
        },
        "paths": survey.paths,
    }


def _degrees(angle: NDArray[Any]) -> list[float]:
    return [round(float(value), 9) for value in angle / deg]
