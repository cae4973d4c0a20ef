"""What Zhou et al. 2025 (Buildings 15, 3046) print in tables 1 to 3 and in section 3, and rows made of it."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from storage.records import TiltRow
from tasks.accuracy import Control, control_of_scheme, relative_error_pct
from tasks.tilt import lean_of_direction
from tests.unit.accuracy.tilt_rows import Fit, tilt_row

HEIGHT_M = 102.0
ARCSEC_DEG = 1.0 / 3600.0
SCHEMES = "ABCDEF"
PROPOSED = "ABCDE"

VECTORS = {
    "A": (0.00734720, -0.00703179, 0.99994828),
    "B": (0.00733996, -0.00697344, 0.99994874),
    "C": (0.00733933, -0.00699452, 0.99994860),
    "D": (0.00731785, -0.00684513, 0.99994979),
    "E": (0.00726479, -0.00666181, 0.99995142),
    "F": (0.00725774, -0.00570779, 0.99995737),
}
SECONDS_OF_AZIMUTH_OVER_90_DEG = {"A": 1515, "B": 1514, "C": 1514, "D": 1509, "E": 1498, "F": 1497}
TILT_ARCSEC = {"A": 2098, "B": 2088, "C": 2091, "D": 2067, "E": 2033, "F": 1905}
VERTICALITY_PERMILLE = {"A": 10.17, "B": 10.12, "C": 10.14, "D": 10.02, "E": 9.86, "F": 9.23}
DEVIATION_M = {"A": 1.0373, "B": 1.0322, "C": 1.0343, "D": 1.0220, "E": 1.0057, "F": 0.9415}
RELATIVE_ERROR_PCT = {"A": 10.13, "B": 9.60, "C": 9.76, "D": 8.50, "E": 6.71}
AZIMUTH_ERROR_PCT = {"A": 0.006, "B": 0.005, "C": 0.005, "D": 0.004, "E": 0.0}
TRUE_AZIMUTH_DEG = {
    "A": 133.743391,
    "B": 133.533160,
    "C": 133.621979,
    "D": 133.088339,
    "E": 132.520813,
    "F": 128.182990,
}
SLICES = {"A": 101, "B": 21, "C": 11, "D": 6, "E": 2, "F": 2}
SHAFT_M = 100.01
THICKNESS_M = 0.01
INTERVAL_M = {"A": 1.0, "B": 5.0, "C": 10.0, "D": 20.0}
MEAN_DEVIATION_MM = {"A": 11.0, "B": 12.3, "C": 13.1, "D": 12.1}
RMSE_MM = {"A": 13.3, "B": 15.4, "C": 15.7, "D": 14.4}


def vector(scheme: str) -> NDArray[np.float64]:
    return np.array(VECTORS[scheme])


def printed_azimuth_deg(scheme: str) -> float:
    return 90.0 + SECONDS_OF_AZIMUTH_OVER_90_DEG[scheme] / 3600.0


def mean_of(printed: Mapping[str, float]) -> float:
    return sum(printed[scheme] for scheme in PROPOSED) / len(PROPOSED)


def error_pct(value: float, reference: float) -> float:
    error = relative_error_pct(value, reference)
    assert isinstance(error, float)
    return error


def paper_rows() -> list[TiltRow]:
    """Rows of the tilt table from the printed vectors, with the printed figures of the fit."""
    return [
        tilt_row(
            scheme,
            lean_of_direction(vector(scheme)),
            Fit(
                n_slices=SLICES[scheme],
                mean_deviation_m=MEAN_DEVIATION_MM[scheme] / 1000 if scheme in MEAN_DEVIATION_MM else None,
                rmse_m=RMSE_MM[scheme] / 1000 if scheme in RMSE_MM else None,
            ),
        )
        for scheme in SCHEMES
    ]


def paper_control(rows: list[TiltRow]) -> Control:
    """Scheme F, the control of the paper."""
    found = control_of_scheme(rows, "F", "paper")
    assert isinstance(found, Control)
    return found
