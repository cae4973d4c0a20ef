"""The figures of several methods on the same campaigns: a table for people, all numbers for a file."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.registration.outcome import Outcome, moved
from tasks.conventions import ARCSEC_RAD

HEADER: Final = (
    "                    lean error  to    moved against  heading, relative   position, relative   time\n"
    'method    n  no shaft rms (")     true  true, rms (")  rms (")             rms (mm)             median (s)'
)


def print_table(outcomes: Sequence[Outcome]) -> None:
    """One row a method; ``no shaft`` counts the campaigns on which none was found in the placed clouds."""
    floors = {o.epoch: o for o in outcomes if o.method == "true"}
    floor = _length([o.error for o in floors.values()])
    print(HEADER)
    for method in dict.fromkeys(o.method for o in outcomes):
        mine = [o for o in outcomes if o.method == method]
        error = _length([o.error for o in mine])
        away = _length([moved(o, floors[o.epoch]) for o in mine])
        failed = sum(o.failure is not None for o in mine)
        seconds = float(np.median([o.seconds for o in mine]))
        print(
            f"{method:7s} {len(mine):3d} {failed:7d} {error:8.2f} {error / floor:8.2f} {away:14.2f}"
            f"{_poses(mine)} {seconds:12.2f}"
        )


def figures(outcomes: Sequence[Outcome]) -> Iterator[dict[str, object]]:
    """Every outcome with all its numbers, in types that JSON knows."""
    floors = {(o.epoch, o.stations): o for o in outcomes if o.method == "true"}
    for o in outcomes:
        away = moved(o, floors[o.epoch, o.stations])
        yield {
            "epoch": o.epoch,
            "stations": o.stations,
            "method": o.method,
            "seconds": o.seconds,
            "lean_error_arcsec": _listed(o.error, ARCSEC_RAD),
            "lean_moved_arcsec": _listed(away, ARCSEC_RAD),
            "lean_sigma_arcsec": o.sigma_arcsec,
            "lean_chi2": o.chi2,
            "pose_errors": None if o.poses is None else _listed(o.poses.errors, 1.0),
            "pose_sigmas": None
            if o.registration is None
            else _listed(np.sqrt(np.diag(o.registration.covariance)), 1.0),
            "iterations": None if o.registration is None else o.registration.iterations,
            "failure": o.failure,
            "notes": o.notes,
        }


def _poses(outcomes: Sequence[Outcome]) -> str:
    placed = [o.poses for o in outcomes if o.poses is not None]
    if not placed:
        return f"{'-':>11s} {'-':>9s} {'-':>11s} {'-':>9s}"
    each = np.array(
        [
            [p.heading_rms_arcsec, p.heading_relative_arcsec, p.position_rms_mm, p.position_relative_mm]
            for p in placed
        ]
    )
    heading, heading_relative, position, position_relative = np.sqrt(np.mean(each**2, axis=0))
    return f"{heading:11.1f} {heading_relative:9.1f} {position:11.1f} {position_relative:9.1f}"


def _length(vectors: Sequence[NDArray[np.float64] | None]) -> float:
    """RMS length of those vectors (2,) that are there, seconds of arc; NaN prints as such where none is."""
    there = [vector for vector in vectors if vector is not None]
    if not there:
        return float("nan")
    return float(np.sqrt(np.mean(np.sum(np.square(there), axis=1)))) / ARCSEC_RAD


def _listed(values: NDArray[np.float64] | None, per_unit: float) -> object:
    return None if values is None else (values / per_unit).tolist()
