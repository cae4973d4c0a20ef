"""Where the adjustment starts: from what is stated, checked against the shaft that every station sees.

The shaft stands where most stations see it. A heading is taken from the direction in which a scan sees it; a station that
sees it at the wrong distance, or of which no position is stated, is placed around it by what else it sees.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np

from tasks.conventions import rotation_site_scanner
from tasks.geometry.failure import FitFailure
from tasks.geometry.side_by_side import side_by_side
from tasks.registration.lost import Neighbours, place_lost
from tasks.registration.planar import ScanPlanes
from tasks.registration.sighting import Sighting, sight_shaft, walls
from tasks.registration.sights import Sights, locate_structure
from tasks.registration.station import InstrumentSigmas, ShaftHint, StationPose, StationScan

AS_STATED: Final = "as stated"
HEADING_SIGMAS: Final = 5.0
SHAFT_M: Final = 1.0
"""How far the shaft may seem to stand aside, because it leans and is not seen over the same heights."""

DISTANCE_M: Final = 1.5
RADIUS_SHARE: Final = 0.25
"""The rough radius may be wrong by that much; a wrong radius puts the axis nearer or farther."""

LEAST_SIGHTINGS: Final = 2
LEAST_PLANES: Final = 50
POSITION_SIGMAS: Final = 5.0
BASE_M: Final = 10.0
"""How far the rough base may be wrong: it is a prior only."""


@dataclass(frozen=True, slots=True)
class Start:
    """Where a station starts and why there.

    ``scan`` is the scan with what is still believed of its statement; ``pose`` is None where the station is refused
    for ``suspicion``.
    """

    scan: StationScan
    pose: StationPose | None
    remark: str = AS_STATED
    suspicion: str | None = None


@dataclass(frozen=True, slots=True)
class Starts:
    """The start of every station, and the structure as they see it: where at mid height, and how wide.

    None if fewer than two see it.
    """

    stations: tuple[Start, ...]
    seen: ShaftHint | None


def find_starts(
    scans: Sequence[StationScan],
    planes: Sequence[ScanPlanes],
    sigmas: InstrumentSigmas,
    hint: ShaftHint | None,
) -> Starts:
    """Start every station; without a hint what is stated is believed."""
    sights = None if hint is None else _sight(scans, planes, hint)
    checked = [_check(i, scan, sights, sigmas) for i, scan in enumerate(scans)]
    if sights is not None:
        checked = _unswapped(checked, sights, sigmas)
    sound = [i for i, one in enumerate(checked) if one.start is not None and one.fault is None]
    neighbours = Neighbours(
        tuple(planes[i] for i in sound),
        tuple(
            start.pose for i in sound if (start := checked[i].start) is not None and start.pose is not None
        ),
    )
    starts = tuple(
        one.start if one.start is not None else _search(one, planes[i], neighbours, sights, i)
        for i, one in enumerate(checked)
    )
    if sights is None or sum(sighting is not None for sighting in sights.sightings) < LEAST_SIGHTINGS:
        return Starts(starts, None)
    east, north = sights.shaft_m
    return Starts(starts, replace(sights.hint, base_xy_m=(float(east), float(north))))


def without_empty(starts: Starts, planes: Sequence[ScanPlanes]) -> Starts:
    """Refuse scans without planes: nothing of them can be compared with another."""
    stations = []
    for start, own in zip(starts.stations, planes, strict=True):
        n_planes = sum(len(layer.points_m) for layer in own.layers)
        if n_planes < LEAST_PLANES:
            why = (
                f"its scan holds {n_planes} planes, needed {LEAST_PLANES}; left out; scan denser, or check whether the "
                "file is in metres"
            )
            stations.append(Start(start.scan, None, suspicion=why))
        else:
            stations.append(start)
    return Starts(tuple(stations), starts.seen)


@dataclass(frozen=True, slots=True)
class _Checked:
    """A scan after its statement was compared with what it sees; no start where it has to be searched for.

    ``fault`` says what is wrong with the statement, in words.
    """

    scan: StationScan
    start: Start | None
    fault: str | None


def _check(i: int, scan: StationScan, sights: Sights | None, sigmas: InstrumentSigmas) -> _Checked:
    sighting = None if sights is None else sights.sightings[i]
    is_whole = scan.position_m is not None and scan.heading_rad is not None
    if sights is None or sighting is None or (is_whole and not sights.is_confirmed):
        # the rough base alone contradicts nobody
        return _Checked(scan, _start_unseen(scan), None)
    if scan.position_m is None:
        return _Checked(scan, None, None)
    to_shaft = sights.shaft_m - scan.position_m[:2]
    wanted_m = float(np.hypot(*to_shaft))
    unsure_m = POSITION_SIGMAS * sigmas.position_m[0]
    base_m = 0.0 if sights.is_confirmed else BASE_M
    allowed_m = DISTANCE_M + RADIUS_SHARE * max(sights.hint.radius_m) + unsure_m + base_m
    if abs(sighting.distance_m - wanted_m) > allowed_m:
        fault = f"the structure is {sighting.distance_m:.1f} m away in its scan, {wanted_m:.1f} m from its stated position"
        return _Checked(scan, None, fault)
    heading = float(np.arctan2(*to_shaft)) - sighting.azimuth_rad
    pose = StationPose(scan.station, rotation_site_scanner(heading), np.asarray(scan.position_m, float))
    if scan.heading_rad is None:
        remark = "heading found by the direction of the structure: none is stated"
        return _Checked(scan, Start(scan, pose, remark), None)
    off = float((heading - scan.heading_rad + np.pi) % (2.0 * np.pi) - np.pi)
    if abs(off) <= HEADING_SIGMAS * sigmas.heading_rad + (SHAFT_M + unsure_m) / wanted_m:
        return _Checked(scan, Start(scan, pose), None)
    fault = (
        f"stated heading is {abs(np.degrees(off)):.1f} deg off and is not used; check heading_deg and scan"
    )
    remark = "heading found by the direction of the structure: the stated one is wrong"
    return _Checked(scan, Start(replace(scan, heading_rad=None), pose, remark, fault), fault)


def _start_unseen(scan: StationScan) -> Start | None:
    """Start of a scan that does not see the structure."""
    if scan.position_m is None:
        why = "no position is stated and its scan does not show the structure, so it cannot be placed; state position_m"
        return Start(scan, None, suspicion=why)
    if scan.heading_rad is None:
        return None
    pose = StationPose(
        scan.station, rotation_site_scanner(scan.heading_rad), np.asarray(scan.position_m, float)
    )
    return Start(scan, pose)


def _unswapped(checked: list[_Checked], sights: Sights, sigmas: InstrumentSigmas) -> list[_Checked]:
    """Put scans of swapped stations where they belong: each fits what is stated of the other."""
    right = list(checked)
    wrong = [i for i, one in enumerate(checked) if one.fault is not None]
    for i, j in combinations(wrong, 2):
        there = _exchanged(i, checked[i].scan, checked[j].scan, sights, sigmas)
        back = _exchanged(j, checked[j].scan, checked[i].scan, sights, sigmas)
        if there is not None and back is not None:
            right[i], right[j] = there, back
    return right


def _exchanged(
    i: int, scan: StationScan, other: StationScan, sights: Sights, sigmas: InstrumentSigmas
) -> _Checked | None:
    """Give a scan what is stated of another; None where that does not fit either."""
    exchanged = replace(scan, position_m=other.position_m, heading_rad=other.heading_rad)
    checked = _check(i, exchanged, sights, sigmas)
    if checked.start is None or checked.fault is not None:
        return None
    fault = (
        f"its scan fits what is stated of {other.station}, and that of {other.station} fits here: the two are swapped, "
        "and each is placed where it stood; correct scan, position_m and heading_deg"
    )
    remark = f"as stated of {other.station}: the two are swapped"
    return _Checked(exchanged, replace(checked.start, remark=remark, suspicion=fault), fault)


def _search(
    checked: _Checked, planes: ScanPlanes, neighbours: Neighbours, sights: Sights | None, i: int
) -> Start:
    scan = checked.scan
    pose = place_lost(scan, planes, neighbours, sights, i)
    if isinstance(pose, FitFailure):
        told = checked.fault or "its pose is not stated whole"
        advice = "left out; check scan, position_m and heading_deg"
        return Start(scan, None, suspicion=f"{told}, and {pose.reason}; {advice}")
    if checked.fault is None:
        missing = [("position", scan.position_m), ("heading", scan.heading_rad)]
        what = " and ".join(name for name, value in missing if value is None)
        return Start(scan, pose, f"{what} found by what stands around the structure: none is stated")
    off_m = float(np.linalg.norm(pose.position_m - np.asarray(scan.position_m)))
    fault = f"stated position is {off_m:.1f} m off and is not used; check position_m, heading_deg and scan"
    remark = "pose found by what stands around the structure: the stated one is wrong"
    return Start(replace(scan, position_m=None, heading_rad=None), pose, remark, fault)


def _sight(scans: Sequence[StationScan], planes: Sequence[ScanPlanes], hint: ShaftHint) -> Sights:
    heights = [float(scan.position_m[2]) for scan in scans if scan.position_m is not None]
    usual_m = float(np.median(heights)) if heights else 0.0
    pairs = list(zip(scans, planes, strict=True))
    sightings = tuple(side_by_side(lambda pair: _sight_one(*pair, hint, usual_m), pairs))
    scales = [sighting.radius_scale for sighting in sightings if sighting is not None]
    scale = float(np.median(scales)) if scales else 1.0
    wide = replace(hint, radius_m=(scale * hint.radius_m[0], scale * hint.radius_m[1]))
    return locate_structure(scans, sightings, wide)


def _sight_one(
    scan: StationScan, planes: ScanPlanes, hint: ShaftHint, usual_height_m: float
) -> Sighting | None:
    """What looks most like the structure; if there are several, the one at the right distance."""
    low, high = hint.shaft_z_m
    up = usual_height_m if scan.position_m is None else float(scan.position_m[2])
    found = sight_shaft(walls(planes), replace(hint, shaft_z_m=(low - up, high - up)))
    if scan.position_m is None:
        return found[0] if found else None
    wanted_m = float(np.hypot(*(np.asarray(hint.base_xy_m) - scan.position_m[:2])))
    return min(found, key=lambda one: abs(one.distance_m - wanted_m), default=None)
