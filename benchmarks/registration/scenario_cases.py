"""Awkward campaigns, each made of a good one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.registration.known import KnownEpoch, KnownStation
from benchmarks.registration.simulated import EVERYTHING, NO_BACKGROUND
from tasks.conventions import ARCSEC_RAD
from tasks.geometry.rotations import rotation_from_vector
from tasks.simulation import Surface, Surroundings

Change = Callable[[KnownEpoch], KnownEpoch]

VICTIM: Final = 2
"""The station that a blunder befalls, counted from 0."""

OTHER: Final = 5


@dataclass(frozen=True, slots=True)
class Case:
    """What becomes of a good epoch of eight stations; ``culprits`` are the stations that ought to be named."""

    change: Change
    culprits: tuple[int, ...] = ()
    surroundings: Surroundings = field(default_factory=Surroundings)
    surfaces: tuple[Surface, ...] = EVERYTHING


def _unchanged(epoch: KnownEpoch) -> KnownEpoch:
    return epoch


def _spread(n: int) -> Change:
    """Keep ``n`` stations, as even all around as eight allow."""

    def change(epoch: KnownEpoch) -> KnownEpoch:
        rows = np.round(np.arange(n) * len(epoch.stations) / n).astype(int)
        return epoch.with_stations([epoch.stations[row] for row in rows])

    return change


def _one_side(epoch: KnownEpoch) -> KnownEpoch:
    """Keep the stations within 180 deg of azimuth from the first on."""
    azimuth = np.array([np.arctan2(*s.true_pose.position_m[:2]) for s in epoch.stations])
    seen = np.flatnonzero((azimuth - azimuth[0]) % (2.0 * np.pi) < np.pi)
    return epoch.with_stations([epoch.stations[row] for row in seen])


def _shifted(shift_m: tuple[float, float, float]) -> Change:
    def change(station: KnownStation) -> KnownStation:
        scan = station.scan
        position_m = None if scan.position_m is None else scan.position_m + np.array(shift_m)
        return replace(station, scan=replace(scan, position_m=position_m))

    return _for_victim(change)


def _turned(turn_deg: float) -> Change:
    def change(station: KnownStation) -> KnownStation:
        scan = station.scan
        heading = None if scan.heading_rad is None else scan.heading_rad + float(np.radians(turn_deg))
        return replace(station, scan=replace(scan, heading_rad=heading))

    return _for_victim(change)


def _tilted(tilt_arcsec: float) -> Change:
    """The scanner is turned about east by more than it knows; its points say so."""
    tilt_rad = (tilt_arcsec * ARCSEC_RAD, 0.0)
    extra = rotation_from_vector(np.array([*tilt_rad, 0.0]))

    def change(station: KnownStation) -> KnownStation:
        true = station.true_pose
        rotation = extra @ true.rotation
        points_m = _seen_with(station.scan.points_m, true.rotation, rotation)
        return KnownStation(
            replace(station.scan, points_m=points_m), replace(true, rotation=rotation), tilt_rad
        )

    return _for_victim(change)


def _seen_with(
    points_m: NDArray[np.float64], before: NDArray[np.float64], after: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Points (n, 3) of a scanner's frame, had it stood with another rotation."""
    return np.asarray(points_m @ (after.T @ before).T)


def _without_position(station: KnownStation) -> KnownStation:
    return replace(station, scan=replace(station.scan, position_m=None))


def _without_heading(station: KnownStation) -> KnownStation:
    return replace(station, scan=replace(station.scan, heading_rad=None))


def _without_either(station: KnownStation) -> KnownStation:
    return _without_heading(_without_position(station))


def _for_victim(change: Callable[[KnownStation], KnownStation]) -> Change:
    return lambda epoch: epoch.with_stations(
        [change(s) if i == VICTIM else s for i, s in enumerate(epoch.stations)]
    )


def _for_all(change: Callable[[KnownStation], KnownStation]) -> Change:
    return lambda epoch: epoch.with_stations([change(s) for s in epoch.stations])


def _swapped(epoch: KnownEpoch) -> KnownEpoch:
    """Two stations with each other's scan: what the crew states of one is true of the other."""
    stations = list(epoch.stations)
    for mine, theirs in ((VICTIM, OTHER), (OTHER, VICTIM)):
        scan, stated = epoch.stations[theirs], epoch.stations[mine].scan
        stations[mine] = KnownStation(
            replace(stated, points_m=scan.scan.points_m), replace(scan.true_pose, station=stated.station)
        )
    return epoch.with_stations(stations)


CASES: Final[Mapping[str, Case]] = {
    "as it should be": Case(_unchanged),
    "5 stations": Case(_spread(5)),
    "4 stations": Case(_spread(4)),
    "3 stations": Case(_spread(3)),
    "2 stations": Case(_spread(2)),
    "one side unseen": Case(_one_side),
    "no background": Case(_unchanged, (), Surroundings(0, 0, 0, 0), NO_BACKGROUND),
    "no GNSS at one": Case(_for_victim(_without_position), (VICTIM,)),
    "no heading at one": Case(_for_victim(_without_heading), (VICTIM,)),
    "neither at one": Case(_for_victim(_without_either), (VICTIM,)),
    "no heading at all": Case(_for_all(_without_heading), tuple(range(8))),
    "heading off by 90 deg": Case(_turned(90.0), (VICTIM,)),
    "heading off by 5 deg": Case(_turned(5.0), (VICTIM,)),
    "heading off by 1.2 deg": Case(_turned(1.2), (VICTIM,)),
    "0.5 m off to the east": Case(_shifted((0.5, 0.0, 0.0)), (VICTIM,)),
    "0.5 m off in height": Case(_shifted((0.0, 0.0, 0.5)), (VICTIM,)),
    "two scans swapped": Case(_swapped, (VICTIM, OTHER)),
    'level off by 60"': Case(_tilted(60.0), (VICTIM,)),
}
