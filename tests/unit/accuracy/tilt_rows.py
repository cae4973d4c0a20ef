"""Rows of the tilt table from lean vectors, for the tests of accuracy and of the paper's tables."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from storage.records import TiltRow
from tasks.tilt import tilt_parameters


@dataclass(frozen=True)
class Fit:
    """What a scheme's axis came from; None as in the tilt table."""

    n_slices: int = 11
    iterations: int | None = None
    mean_deviation_m: float | None = None
    rmse_m: float | None = None
    covariance: NDArray[np.float64] | None = None


UNKNOWN: Final[Mapping[str, Any]] = dict.fromkeys(
    (
        "point_cov_ee",
        "point_cov_en",
        "point_cov_nn",
        "verdict_reason",
        "update_weight_ratio_pct",
        "n_effective",
        "bending_m",
    )
)
"""What neither accuracy nor the tables of the paper ask for."""


def tilt_row(
    scheme: str,
    lean: NDArray[np.float64],
    fit: Fit | None = None,
    method: str = "paper",
    epoch: str = "2025-03",
) -> TiltRow:
    fit = fit or Fit()
    p = tilt_parameters(lean, fit.covariance, 102.0)
    C = fit.covariance
    return TiltRow(
        structure="chimney-01",
        epoch=epoch,
        epoch_time=datetime(2025, 3, 14, tzinfo=UTC),
        scheme=scheme,
        method=method,
        n_slices=fit.n_slices,
        n_centres=fit.n_slices,
        base_east_m=0.0,
        base_north_m=0.0,
        d_east=p.d_east,
        d_north=p.d_north,
        d_up=p.d_up,
        lean_east=float(lean[0]),
        lean_north=float(lean[1]),
        lean_cov_ee=None if C is None else float(C[0, 0]),
        lean_cov_en=None if C is None else float(C[0, 1]),
        lean_cov_nn=None if C is None else float(C[1, 1]),
        **UNKNOWN,
        tilt_deg=p.tilt_deg,
        tilt_sigma_deg=p.tilt_sigma_deg,
        azimuth_deg=p.azimuth_deg,
        azimuth_sigma_deg=p.azimuth_sigma_deg,
        beta_deg=p.beta_deg,
        verticality_permille=p.verticality_permille,
        height_m=102.0,
        deviation_m=p.deviation_m,
        deviation_sigma_m=p.deviation_sigma_m,
        allowable_m=0.0605,
        verdict="cannot tell",
        iterations=fit.iterations,
        mean_deviation_m=fit.mean_deviation_m,
        rmse_m=fit.rmse_m,
    )
