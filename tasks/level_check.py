"""Does every station see the shaft as plumb as the others do: finds a scanner out of level, which nothing else sees.

A scan-to-scan adjustment hardly notices a wrong level, because the level itself is held. But the half shaft of a station
that is out of level leans against the common one, by its own error, and that shows in arc seconds.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import MAD_TO_SIGMA, TUKEY_1D
from tasks.geometry.side_by_side import side_by_side
from tasks.preprocessing import ShaftModel

LEAST_POINTS: Final = 500
"""Fewer points of a station on the shaft tell nothing of its level."""

MOST_POINTS: Final = 200_000
"""Of more points of a station as many are taken, evenly: 3 mm of noise then leave a tenth of a second of arc, and the form
of the shaft and the stated level, which more points do not make smaller, leave seconds."""

REWEIGHTINGS: Final = 4

SECTOR_DEG: Final = 10.0
BAND_M: Final = 5.0
USUAL_SIGMAS: Final = 4.0
LEAST_IN_PIECE: Final = 5
LEAST_PIECES: Final = 30
FORM_BLOCKS: Final = 10.0
"""So many independent pieces of form a half shaft shows: out of round is smooth around and along it."""

SUSPECT_CHI2: Final = 20.0
"""Chi-square of 2 degrees of freedom that chance reaches in one of 20,000 stations. Simulated stations within their
stated level stayed below 6, one 20 seconds out reached 33, one 60 seconds out 295."""


@dataclass(frozen=True, slots=True)
class LevelCheck:
    """How much a station's half shaft leans against the common one, and how unlikely that is.

    ``lean_east`` and ``lean_north`` are dimensionless; ``chi2`` has 2 degrees of freedom and covers the noise of the
    points, the form of the shaft and the stated level. All are None for a station with too few points on the shaft, and
    for a shaft with plane faces, whose lean a station that sees two of them cannot tell from their taper.
    """

    lean_east: float | None
    lean_north: float | None
    chi2: float | None


NOT_CHECKED: Final = LevelCheck(None, None, None)


def check_levels(
    points_m: NDArray[np.float64],
    station_index: NDArray[np.uint16],
    model: ShaftModel,
    level_sigmas_rad: Sequence[float],
) -> tuple[LevelCheck, ...]:
    """Check the stations of an epoch against the shaft that all of them see.

    Parameters
    ----------
    points_m : (n, 3) array
        Points of the isolated shaft, site frame, metres.
    station_index : (n,) array
        Which station saw each.
    model : ShaftModel
        The common shaft.
    level_sigmas_rad : sequence of float
        Standard deviation of one component of the level, a station each.
    """
    n = len(level_sigmas_rad)
    if n < 2 or not model.is_round:
        return (NOT_CHECKED,) * n
    # the common shaft follows each station by its share: what is left of its own level is smaller
    own = np.sqrt((n - 1) / n)
    rows = _rows_evenly(station_index, n)

    def check(station: int) -> LevelCheck:
        return _check_one(points_m[rows[station]], model, own * level_sigmas_rad[station])

    return tuple(side_by_side(check, range(n)))


def worst_suspect(checks: Sequence[LevelCheck]) -> int | None:
    """Index of the station that is most out of level, if any is.

    One only: a bad station moves the common shaft, and the others then look worse than they are.
    """
    chi2 = [check.chi2 if check.chi2 is not None else 0.0 for check in checks]
    worst = int(np.argmax(chi2)) if chi2 else 0
    return worst if chi2 and chi2[worst] > SUSPECT_CHI2 else None


def _rows_evenly(station_index: NDArray[np.uint16], n_stations: int) -> list[NDArray[np.int64]]:
    """Rows of at most ``MOST_POINTS`` points of every station."""
    from tasks.level_kernel import count_stations, take_places  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    places = [
        np.arange(n) if n <= MOST_POINTS else np.linspace(0, n - 1, MOST_POINTS).astype(np.int64)
        for n in count_stations(station_index, n_stations)
    ]
    ends = np.cumsum([0, *(len(of_station) for of_station in places)])
    rows = np.empty(ends[-1], dtype=np.int64)
    take_places(station_index, np.concatenate(places), ends, rows)
    return np.split(rows, ends[1:-1])


def _check_one(points_m: NDArray[np.float64], model: ShaftModel, level_sigma_rad: float) -> LevelCheck:
    if len(points_m) < LEAST_POINTS:
        return NOT_CHECKED
    z = points_m[:, 2]
    away = points_m[:, :2] - model.axis_at(z)
    distance = np.hypot(*away.T)
    outward = away / distance[:, None]
    residual = distance - model.radius_at(z)
    height = z - z.mean()
    # shift and lean of the half shaft against the common one, and what the radius is off
    design = np.column_stack([outward, outward * height[:, None], np.ones(len(z))])
    fit = _robust_fit(design, residual)
    lean = fit.solution[2:4]
    away_m = residual - design @ fit.solution
    form = _form_covariance(design, _form_sigma_m(away_m, np.arctan2(*outward.T), z, fit.sigma_m))
    spread = (fit.covariance + form)[2:4, 2:4] + level_sigma_rad**2 * np.eye(2)
    return LevelCheck(float(lean[0]), float(lean[1]), float(lean @ np.linalg.solve(spread, lean)))


def _form_sigma_m(
    away_m: NDArray[np.float64], azimuth_rad: NDArray[np.float64], z_m: NDArray[np.float64], noise_m: float
) -> float:
    """How far the shaft is out of the common form, from the scatter of the medians of its pieces; without their noise."""
    sector = np.floor(np.degrees(azimuth_rad) / SECTOR_DEG).astype(np.int64)
    band = np.floor((z_m - z_m.min()) / BAND_M).astype(np.int64)
    _, piece, counts = np.unique(sector * 10_000 + band, return_inverse=True, return_counts=True)
    usual = np.abs(away_m) < USUAL_SIGMAS * noise_m
    sums = np.bincount(piece[usual], weights=away_m[usual], minlength=len(counts))
    n = np.bincount(piece[usual], minlength=len(counts))
    full = n >= LEAST_IN_PIECE
    if np.count_nonzero(full) < LEAST_PIECES:
        return noise_m
    means = sums[full] / n[full]
    own_noise = float(np.median(noise_m**2 / n[full]))
    return float(np.sqrt(max((MAD_TO_SIGMA * np.median(np.abs(means))) ** 2 - own_noise, 0.0)))


def _form_covariance(design: NDArray[np.float64], form_m: float) -> NDArray[np.float64]:
    """Covariance (p, p) of the coefficients that the form of the shaft causes: it is seen in few independent pieces."""
    mean_information = design.T @ design / len(design)
    return np.asarray(np.linalg.inv(mean_information) * form_m**2 / FORM_BLOCKS)


@dataclass(frozen=True, slots=True)
class _RobustFit:
    """Coefficients (p,), their covariance (p, p) from the scatter, and its scale."""

    solution: NDArray[np.float64]
    covariance: NDArray[np.float64]
    sigma_m: float


def _robust_fit(design: NDArray[np.float64], residual: NDArray[np.float64]) -> _RobustFit:
    """Fit by Tukey's weights."""
    from tasks.level_kernel import weigh_rows  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    error = residual - np.median(residual)
    for _ in range(REWEIGHTINGS):
        sigma = max(float(MAD_TO_SIGMA * np.median(np.abs(error))), 1e-9)
        normal, right = weigh_rows(design, residual, error, TUKEY_1D * sigma)
        solution = np.linalg.solve(normal, right)
        error = residual - design @ solution
    return _RobustFit(np.asarray(solution), np.asarray(np.linalg.inv(normal) * sigma**2), sigma)
