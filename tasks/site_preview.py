"""What can be told while the crew is still on site: coverage so far, expected sigma, which side is missing, where next.

It rests on the stated poses and a quick look at each scan, without any registration: a preview, and no result.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.arrivals import request_of
from tasks.conventions import azimuth_deg, rotation_site_scanner
from tasks.design import BestPlace, Site, Survey, best_place, whole_surface
from tasks.design.normals import StationNormals, station_normals
from tasks.design.prediction import Prediction, predict_lean
from tasks.design.shaft import Bands, Cells, cut_cells
from tasks.design.sight import View, look
from tasks.geometry.failure import FitFailure
from tasks.ingest import read_scan
from tasks.quick_look import QuickLook, quick_look, thinned
from tasks.settings import Campaign, Station
from tasks.settings.intake import Intake
from tasks.survey_design import survey_of_sites

SECTORS: Final = 36
SECTOR_DEG: Final = 10.0
SEEN_AT: Final = 0.5
"""A sector counts as seen where points lie in it at this share of the heights."""

ROUGH_FOOT_M: Final = 0.5
"""By how much base_xy_m may be off."""

USUAL_DISTANCE: Final = (1.0,)
"""A next station is looked for as far from the axis as the others; nearer and farther ones take five times as long."""

MOST_POINTS: Final = 20_000_000
MOST_BYTES: Final = 1_000_000_000
"""Larger scans are not read for a preview: it would take long, and memory that a run beside it needs."""


@dataclass(frozen=True, slots=True)
class StationLook:
    """A station as the preview sees it: where it stood, and what its scan holds; or why that is not known."""

    station: str
    site: Site | None
    seen: QuickLook | None
    reason: str | None


@dataclass(frozen=True, slots=True)
class SitePreview:
    """What can be told of an epoch that is being measured.

    ``covered_deg`` is the part of the circumference that was seen, over all heights, None where no scan could be looked
    at; ``unseen_deg`` are sectors of azimuth about the axis, clockwise, that were seen at less than half of the heights.
    ``lean`` is the expected uncertainty of the stations that were looked at; ``place`` where one more helps most; each
    may be missing with a reason.
    """

    structure: str
    epoch: str
    height_m: float
    looks: tuple[StationLook, ...]
    missing: tuple[str, ...]
    covered_deg: float | None
    unseen_deg: tuple[tuple[float, float], ...]
    lean: Prediction | FitFailure
    place: BestPlace | FitFailure


def look_at_station(campaign: Campaign, station: Station, n_points: int | None) -> StationLook:
    """Read the scan of a station and find the shaft in it by its stated pose.

    Parameters
    ----------
    campaign
        Says what is roughly known of the structure.
    station
        The station; its scan is relative to the campaign file.
    n_points
        Points by the header, where it says so.
    """
    if n_points is not None and n_points > MOST_POINTS:
        return StationLook(station.id, None, None, f"{n_points:,} points are too many for a quick look")
    try:
        path = campaign.scan_path(station.scan)
        if n_points is None and path.is_file() and path.stat().st_size > MOST_BYTES:
            return StationLook(station.id, None, None, "the scan is too large for a quick look")
        scan = read_scan(path, request_of(station))
    except InputError as fault:
        return StationLook(station.id, None, None, str(fault))
    few_m, scale = thinned(scan.points_m)
    if scan.pose is not None and station.pose == "file":
        forward = scan.pose.rotation[:, 1]
        stated, heading_deg = scan.pose.translation.tolist(), azimuth_deg(forward[0], forward[1])
    elif station.position_m is None or station.heading_deg is None:
        return StationLook(
            station.id, None, None, "no position or heading is stated; the run will search for it"
        )
    else:
        stated, heading_deg = station.position_m, station.heading_deg
    position_m = campaign.frame.site_position_m((stated[0], stated[1], stated[2]))
    points_m = few_m @ rotation_site_scanner(float(np.radians(heading_deg))).T + position_m
    return _looked(campaign, station, Site(station.id, position_m), points_m, scale)


def preview(
    campaign: Campaign, intake: Intake, looks: Sequence[StationLook], missing: Sequence[str]
) -> SitePreview:
    """Put what the stations saw together.

    Parameters
    ----------
    campaign
        What is roughly known of the structure, and what the maker of the scanner states.
    intake
        The epoch so far.
    looks
        Its stations.
    missing
        Ids of the stations that are still to come, where that is known.
    """
    used = [one for one in looks if one.site is not None and one.seen is not None]
    counts = [one.seen.counts for one in used if one.seen is not None]
    seen = _sectors_seen(np.sum(counts, axis=0)) if counts else None
    lean, place = _outlook(campaign, used)
    return SitePreview(
        structure=campaign.structure.id,
        epoch=intake.epoch,
        height_m=campaign.structure.height_m,
        looks=tuple(looks),
        missing=tuple(missing),
        covered_deg=None if seen is None else float(360.0 * seen.mean()),
        unseen_deg=() if seen is None else _arcs(seen.mean(axis=0) < SEEN_AT),
        lean=lean,
        place=place,
    )


def preview_facts(found: SitePreview) -> Mapping[str, object]:
    """A preview for programs: metres, degrees, null where something does not exist."""
    lean, place = found.lean, found.place
    is_known, is_place = isinstance(lean, Prediction), isinstance(place, BestPlace)
    return {
        "structure": found.structure,
        "epoch": found.epoch,
        "is_preview": True,
        "based_on": "stated poses and a quick look at each scan; nothing is registered",
        "stations": [_station_facts(one) for one in found.looks],
        "missing_stations": list(found.missing),
        "covered_deg": found.covered_deg,
        "unseen_deg": [list(arc) for arc in found.unseen_deg],
        "sigma_worst_arcsec": lean.sigma_worst_arcsec if isinstance(lean, Prediction) else None,
        "sigma_worst_m": found.height_m * lean.sigma_worst if isinstance(lean, Prediction) else None,
        "worst_azimuth_deg": lean.worst_azimuth_deg if isinstance(lean, Prediction) else None,
        "sigma_reason": None if is_known else str(getattr(lean, "reason", "")),
        "next_azimuth_deg": place.azimuth_deg if isinstance(place, BestPlace) else None,
        "next_distance_m": place.distance_m if isinstance(place, BestPlace) else None,
        "next_position_m": list(place.site.position_m) if isinstance(place, BestPlace) else None,
        "next_sigma_worst_arcsec": place.lean.sigma_worst_arcsec if isinstance(place, BestPlace) else None,
        "next_reason": None if is_place else str(getattr(place, "reason", "")),
    }


def _looked(
    campaign: Campaign, station: Station, site: Site, points_m: NDArray[np.float64], scale: float
) -> StationLook:
    try:
        shaft = survey_of_sites(campaign, (site,)).shaft
    except InputError as fault:
        return StationLook(station.id, site, None, str(fault))
    away_m = hypot(site.position_m[0] - shaft.base_xy_m[0], site.position_m[1] - shaft.base_xy_m[1])
    instrument = campaign.instrument
    heading_m = float(np.radians(instrument.heading_sigma_deg)) * away_m
    seen = quick_look(points_m, scale, shaft, hypot(ROUGH_FOOT_M, heading_m, instrument.position_sigma_m[0]))
    if isinstance(seen, FitFailure):
        return StationLook(station.id, site, None, seen.reason)
    return StationLook(station.id, site, seen, None)


def _station_facts(one: StationLook) -> Mapping[str, object]:
    seen = one.seen
    return {
        "station": one.station,
        "n_points_on_shaft": None if seen is None else seen.n_on_shaft,
        "covered_deg": None if seen is None else float(360.0 * _sectors_seen(seen.counts).mean()),
        "shift_m": None if seen is None else seen.shift_m,
        "reason": one.reason,
    }


def _sectors_seen(counts: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Bands and sectors of 10 degrees (b, SECTORS) with points."""
    return np.asarray(counts.reshape(len(counts), SECTORS, -1).sum(axis=2) > 0)


def _arcs(flagged: NDArray[np.bool_]) -> tuple[tuple[float, float], ...]:
    """Runs of flagged sectors (SECTORS,) as azimuths from and to, clockwise; a run across north is one."""
    if flagged.all():
        return ((0.0, 360.0),)
    starts = np.flatnonzero(flagged & ~np.roll(flagged, 1))
    arcs = []
    for start in starts:
        length = int(np.argmin(np.roll(flagged, -int(start))))
        arcs.append((SECTOR_DEG * start, (SECTOR_DEG * (start + length)) % 360.0))
    return tuple((float(a), float(b)) for a, b in arcs)


def _outlook(
    campaign: Campaign, used: Sequence[StationLook]
) -> tuple[Prediction | FitFailure, BestPlace | FitFailure]:
    """Expected covariance of the lean with what was seen, and the best place for one more station."""
    if not used:
        nothing = FitFailure("no station could be looked at")
        return nothing, nothing
    try:
        survey = survey_of_sites(campaign, tuple(one.site for one in used if one.site is not None))
    except InputError as fault:
        nothing = FitFailure(str(fault))
        return nothing, nothing
    per_station = [one.seen.n_on_shaft for one in used if one.seen is not None]
    survey = replace(survey, points_per_station=float(max(np.median(per_station), 1.0)))
    cells = cut_cells(survey.shaft, survey.bands)
    parts = [_part(survey, cells, one.site, one.seen) for one in used if one.site and one.seen]
    return predict_lean(cells, parts, survey.errors), best_place(survey, parts, USUAL_DISTANCE)


def _part(survey: Survey, cells: Cells, site: Site, seen: QuickLook) -> StationNormals:
    """What the points that a station did get say of the lean."""
    whole = whole_surface(survey.shaft)
    expected = look(cells, site, survey.scanning, survey.errors)
    return station_normals(cells, site, View(_on_bands(seen.counts, whole, survey.bands), expected.sigma_m))


def _on_bands(counts: NDArray[np.float64], whole: Bands, bands: Bands) -> NDArray[np.float64]:
    """Points by band of the whole surface (w, c) shared out over the bands that are measured (b, c)."""
    nearest = np.abs(bands.z_m[:, None] - whole.z_m[None, :]).argmin(axis=1)
    share = bands.thickness_m / whole.thickness_m[nearest]
    return np.asarray(counts[nearest] * share[:, None])
