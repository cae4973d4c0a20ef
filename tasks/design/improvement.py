"""Where one more station would help a planned survey most."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from tasks.design.normals import StationNormals, station_normals
from tasks.design.prediction import Prediction, predict_lean
from tasks.design.shaft import cut_cells, whole_surface
from tasks.design.sight import Site
from tasks.design.survey import Survey, sites_at, survey_normals, view_of
from tasks.geometry.failure import FitFailure

AZIMUTHS_DEG: Final = tuple(10.0 * i for i in range(36))
DISTANCES: Final = (0.5, 0.75, 1.0, 1.25, 1.5)
"""Distances that are tried, in units of the median of the others."""

NEAREST_RADII: Final = 3.0
"""A scanner stands no nearer to the axis than so many of the largest radius."""

AS_GOOD: Final = 1.005
"""Places within half a per cent of the best sigma are as good; the one nearest to the usual distance is taken."""


@dataclass(frozen=True, slots=True)
class BestPlace:
    """The best place for one more station, and the prediction with it."""

    site: Site
    azimuth_deg: float
    distance_m: float
    lean: Prediction


def best_place(
    survey: Survey,
    seen: Sequence[StationNormals] | None = None,
    distances: Sequence[float] = DISTANCES,
) -> BestPlace | FitFailure:
    """Try one more station on a grid of azimuths and distances, as high as the others in the median.

    It scans as they do; of what hides the shaft only that holds for it which hides it from all. Whether there is ground
    to stand on is not known.

    Parameters
    ----------
    survey : Survey
        The stations, and how they scan.
    seen : sequence of StationNormals, optional
        What the stations did see, over the bands of the survey; predicted where it is left out.
    distances : sequence of float
        Distances that are tried, in units of the median of the others.
    """
    measured, whole = (
        cut_cells(survey.shaft, survey.bands),
        cut_cells(survey.shaft, whole_surface(survey.shaft)),
    )
    parts = survey_normals(survey, measured) if seen is None else seen
    usual_m, found = _median_distance_m(survey), []
    for distance_m in _distances_m(survey, distances):
        for azimuth, site in zip(AZIMUTHS_DEG, _ring(survey, distance_m), strict=True):
            part = station_normals(measured, site, view_of(survey, measured, site, whole))
            lean = predict_lean(measured, [*parts, part], survey.errors)
            if isinstance(lean, Prediction):
                found.append(BestPlace(site, azimuth, distance_m, lean))
    if not found:
        return FitFailure("needed a place from which the shaft can be seen, none of the grid is one")
    least = min(place.lean.sigma_worst for place in found)
    good = [place for place in found if place.lean.sigma_worst <= AS_GOOD * least]
    return min(good, key=lambda place: (abs(place.distance_m - usual_m), place.lean.sigma_worst))


def _ring(survey: Survey, distance_m: float) -> tuple[Site, ...]:
    up_m = float(np.median([site.position_m[2] for site in survey.sites]))
    ring = sites_at(survey.shaft, AZIMUTHS_DEG, distance_m, up_m)
    return tuple(Site("one more", site.position_m) for site in ring)


def _median_distance_m(survey: Survey) -> float:
    off_m = np.array([site.position_m[:2] for site in survey.sites]) - survey.shaft.base_xy_m
    return float(np.median(np.hypot(*off_m.T)))


def _distances_m(survey: Survey, distances: Sequence[float]) -> list[float]:
    usual_m, nearest_m = _median_distance_m(survey), NEAREST_RADII * max(survey.shaft.radius_m)
    return sorted({max(share * usual_m, nearest_m) for share in distances})
