"""Where the structure stands, from what the stations of an epoch see of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import rotation_site_scanner
from tasks.registration.sighting import Sighting
from tasks.registration.station import ShaftHint, StationScan

DIRECTION_SIGMA_M: Final = 1.0
"""Of a place seen at a stated position and heading: 0.15 degrees at 250 m, and a shaft that leans."""

DISTANCE_SIGMA_M: Final = 1.0
BASE_SIGMA_M: Final = 5.0
"""Of the rough base, which is a prior only."""

AGREES_M: Final = 3.0
LEAST_AGREEING: Final = 2


@dataclass(frozen=True, slots=True)
class Sights:
    """What every station sees of the shaft, and where that stands at mid height (2,) in the site frame.

    ``hint`` has the radius as it is seen. ``is_confirmed`` where two stations at least, and more than half of those that
    see it, agree on the place.
    """

    sightings: tuple[Sighting | None, ...]
    shaft_m: NDArray[np.float64]
    hint: ShaftHint
    is_confirmed: bool


def locate_structure(
    scans: Sequence[StationScan], sightings: tuple[Sighting | None, ...], hint: ShaftHint
) -> Sights:
    """Find the place that most sightings agree on: by direction where a heading is stated, else by distance alone."""
    from scipy.optimize import least_squares  # noqa: PLC0415 (slow to import)

    base = np.asarray(hint.base_xy_m, dtype=np.float64)
    seen = [
        (scan, sighting)
        for scan, sighting in zip(scans, sightings, strict=True)
        if sighting is not None and scan.position_m is not None
    ]
    places = [place for one in seen if (place := _place_m(*one)) is not None]
    start = np.median(places, axis=0) if places else base

    def misfits(at_m: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.concatenate([_misfit(*one, at_m) for one in seen] + [(at_m - base) / BASE_SIGMA_M])

    found = np.asarray(least_squares(misfits, start, loss="cauchy").x, dtype=np.float64)
    n_agreeing = sum(_agrees(*one, found) for one in seen)
    is_confirmed = n_agreeing >= LEAST_AGREEING and 2 * n_agreeing > len(seen)
    return Sights(sightings, found, hint, is_confirmed)


def _place_m(scan: StationScan, sighting: Sighting) -> NDArray[np.float64] | None:
    """Where a station sees the structure (2,); None without a heading."""
    if scan.position_m is None or scan.heading_rad is None:
        return None
    turn = rotation_site_scanner(scan.heading_rad)[:2, :2]
    return np.asarray(scan.position_m[:2] + turn @ sighting.centre_m)


def _distance_misfit_m(scan: StationScan, sighting: Sighting, at_m: NDArray[np.float64]) -> float:
    if scan.position_m is None:
        return 0.0
    return float(np.hypot(*(at_m - scan.position_m[:2]))) - sighting.distance_m


def _misfit(scan: StationScan, sighting: Sighting, at_m: NDArray[np.float64]) -> NDArray[np.float64]:
    place = _place_m(scan, sighting)
    if place is None:
        return np.array([_distance_misfit_m(scan, sighting, at_m) / DISTANCE_SIGMA_M])
    return np.asarray((place - at_m) / DIRECTION_SIGMA_M)


def _agrees(scan: StationScan, sighting: Sighting, at_m: NDArray[np.float64]) -> bool:
    place = _place_m(scan, sighting)
    if place is None:
        return abs(_distance_misfit_m(scan, sighting, at_m)) < AGREES_M
    return float(np.hypot(*(place - at_m))) < AGREES_M
