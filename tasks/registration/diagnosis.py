"""What is said of every station after the adjustment: how it was corrected, how well it is known, whether to believe it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.conventions import azimuth_deg
from tasks.registration.adjustment import Adjusted
from tasks.registration.observability import weakest_direction
from tasks.registration.shaft_factor import LEAST_POINTS
from tasks.registration.start import Start
from tasks.registration.statement_test import Settled, corrections, normalised_corrections
from tasks.registration.station import PoseDiagnosis, StationScan

MIN_OVERLAP: Final = 0.05
"""Share of its planes that a station must have in common with one other at least."""


def diagnose_stations(
    settled: Settled, covariance: NDArray[np.float64], starts: Sequence[Start], scans: Sequence[StationScan]
) -> tuple[PoseDiagnosis, ...]:
    """One diagnosis a station, in the order of the poses.

    Parameters
    ----------
    settled : Settled
        The adjustment.
    covariance : (6n, 6n) array
        Of the poses.
    starts : sequence of Start
        Where each station started.
    scans : sequence of StationScan
        What the crew stated, whether it was believed or not.
    """
    normalised = normalised_corrections(settled.network, settled.adjusted)
    sigmas = np.sqrt(np.diag(covariance)).reshape(-1, SIX)
    return tuple(
        _diagnose(i, settled, _Known(sigmas[i], normalised[i]), start, scan)
        for i, (start, scan) in enumerate(zip(starts, scans, strict=True))
    )


def best_overlap(i: int, adjusted: Adjusted) -> float | None:
    """Largest share of a station's planes that match one other; None where it has no planes or no other is there."""
    shares = []
    for other in range(len(adjusted.poses)):
        both = [
            found for (source, target, _), found in adjusted.matches.items() if (source, target) == (i, other)
        ]
        n_queries = sum(found.n_queries for found in both)
        if n_queries:
            shares.append(sum(len(found.residuals_m) for found in both) / n_queries)
    return max(shares, default=None)


def is_tied(i: int, adjusted: Adjusted) -> bool:
    """Whether anything but its statement holds a station: planes in common with another, or the common shaft."""
    overlap = best_overlap(i, adjusted)
    return adjusted.n_on_shaft[i] >= LEAST_POINTS or (overlap is not None and overlap >= MIN_OVERLAP)


@dataclass(frozen=True, slots=True)
class _Known:
    """Sigmas (6,) of a pose, and its corrections (6,) in units of their own sigma."""

    sigmas: NDArray[np.float64]
    normalised: NDArray[np.float64]


def _diagnose(i: int, settled: Settled, known: _Known, start: Start, scan: StationScan) -> PoseDiagnosis:
    adjusted = settled.adjusted
    pose = adjusted.poses[i]
    level = corrections(adjusted, settled.network.stated)[i, :2]
    forward = pose.rotation @ np.array([0.0, 1.0, 0.0])
    heading = float(np.arctan2(forward[0], forward[1]))
    overlap = best_overlap(i, adjusted)
    reasons = _reasons(i, settled, start, overlap)
    return PoseDiagnosis(
        station=pose.station,
        heading_rad=float(np.radians(azimuth_deg(forward[0], forward[1]))),
        heading_correction_rad=None if scan.heading_rad is None else _wrapped(heading - scan.heading_rad),
        level_east_rad=float(level[0]),
        level_north_rad=float(level[1]),
        overlap=overlap,
        rmse_m=_rmse(i, adjusted),
        sigma_heading_rad=float(known.sigmas[2]),
        sigma_level_rad=float(np.sqrt(np.mean(known.sigmas[:2] ** 2))),
        sigma_position_m=float(np.sqrt(np.mean(known.sigmas[3:] ** 2))),
        weakest_direction=weakest_direction(adjusted.data_information, adjusted.prior_information, i),
        state="suspect" if reasons else "ok",
        reason="; ".join(reasons) or None,
        start=start.remark,
        correction_m=None if scan.position_m is None else pose.position_m - np.asarray(scan.position_m),
        normalised=tuple(None if np.isnan(value) else float(value) for value in known.normalised),
    )


def _wrapped(angle_rad: float) -> float:
    return float((angle_rad + np.pi) % (2.0 * np.pi) - np.pi)


def _rmse(i: int, adjusted: Adjusted) -> float | None:
    """Root mean square of the robust scales of the pairs of a station, by their matches."""
    scales = [
        (found.sigma_m, len(found.residuals_m))
        for (source, _, _), found in adjusted.matches.items()
        if source == i and found.sigma_m is not None
    ]
    total = sum(n for _, n in scales)
    return float(np.sqrt(sum(sigma**2 * n for sigma, n in scales) / total)) if total else None


def _reasons(i: int, settled: Settled, start: Start, overlap: float | None) -> list[str]:
    reasons = [] if start.suspicion is None else [start.suspicion]
    reasons += [wrong.reason for wrong in settled.wrong if wrong.index == i]
    if overlap is not None and not is_tied(i, settled.adjusted):
        reasons.append(
            f"{100 * overlap:.0f} % of its planes match any other station, needed {100 * MIN_OVERLAP:.0f} %: "
            "check heading_deg and position_m"
        )
    if settled.is_contradictory:
        reasons.append(
            "what is stated of half the stations or more contradicts the scans, so nobody knows which are right: check "
            "instrument.*_sigma, position_m and heading_deg"
        )
    if not settled.adjusted.converged:
        reasons.append("the joint adjustment of the epoch did not converge")
    return reasons
