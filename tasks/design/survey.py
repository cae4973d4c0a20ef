"""A survey before anybody goes out: the whole prediction from shaft, sites, scanner and errors."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.conventions import azimuth_deg
from tasks.design.normals import StationNormals, station_normals
from tasks.design.prediction import Prediction, predict_lean
from tasks.design.shaft import Bands, Cells, Shaft, cut_cells, whole_surface
from tasks.design.sight import Errors, Hidden, Scanning, Site, View, look, spacing_for
from tasks.geometry.failure import FitFailure


@dataclass(frozen=True, slots=True)
class Survey:
    """What is planned.

    ``bands`` are the heights whose points the lean will come from, the whole surface or slices. ``points_per_station``
    takes the place of the spacing of ``scanning``: that many points on the whole shaft.
    """

    shaft: Shaft
    bands: Bands
    sites: tuple[Site, ...]
    scanning: Scanning
    errors: Errors
    hidden: tuple[Hidden, ...] = ()
    points_per_station: float | None = None

    def __post_init__(self) -> None:
        names = [site.station for site in self.sites]
        if not names or len(set(names)) < len(names):
            raise ShapeError(f"a survey needs stations, each with a name of its own; got {names}")


@dataclass(frozen=True, slots=True)
class StationOutlook:
    """What one station will do: points on the whole shaft, and what it would cost to leave it out.

    ``without`` is the prediction without the station, or why there is none.
    """

    site: Site
    azimuth_deg: float
    distance_m: float
    n_points: float
    n_points_used: float
    covered_deg: float
    pull: float
    without: Prediction | FitFailure


@dataclass(frozen=True, slots=True)
class Sighted:
    """Which stations see what of the whole surface: ``seen_by`` (b, CELLS_ROUND) counts them."""

    bands: Bands
    seen_by: NDArray[np.int64]

    @property
    def covered_deg(self) -> NDArray[np.float64]:
        """Circumference (b,) that some station sees, degrees, by height."""
        return np.asarray(360.0 * (self.seen_by > 0).mean(axis=1))


@dataclass(frozen=True, slots=True)
class Outlook:
    """Everything that is predicted of a survey."""

    survey: Survey
    lean: Prediction
    stations: tuple[StationOutlook, ...]
    sighted: Sighted


def foresee(survey: Survey) -> Outlook | FitFailure:
    """Predict what a survey will give, and what every station adds to it."""
    measured, whole = (
        cut_cells(survey.shaft, survey.bands),
        cut_cells(survey.shaft, whole_surface(survey.shaft)),
    )
    views = [view_of(survey, whole, site, whole) for site in survey.sites]
    used = [view_of(survey, measured, site, whole) for site in survey.sites]
    parts = [station_normals(measured, site, view) for site, view in zip(survey.sites, used, strict=True)]
    lean = predict_lean(measured, parts, survey.errors)
    if isinstance(lean, FitFailure):
        return lean
    stations = tuple(
        StationOutlook(
            site,
            *_place(survey.shaft, site),
            n_points=float(views[i].counts.sum()),
            n_points_used=float(used[i].counts.sum()),
            covered_deg=360.0 * float(views[i].is_seen.any(axis=0).mean()),
            pull=float(lean.pull[i]),
            without=predict_lean(measured, [*parts[:i], *parts[i + 1 :]], survey.errors),
        )
        for i, site in enumerate(survey.sites)
    )
    seen_by = np.sum([view.is_seen for view in views], axis=0)
    return Outlook(survey, lean, stations, Sighted(whole.bands, seen_by))


def predict_survey(survey: Survey) -> Prediction | FitFailure:
    """Predict the lean of a survey and nothing else."""
    measured = cut_cells(survey.shaft, survey.bands)
    return predict_lean(measured, survey_normals(survey, measured), survey.errors)


def survey_normals(survey: Survey, measured: Cells) -> list[StationNormals]:
    """Sum up what each station says, over the cells that are measured."""
    whole = cut_cells(survey.shaft, whole_surface(survey.shaft))
    return [station_normals(measured, site, view_of(survey, measured, site, whole)) for site in survey.sites]


def view_of(survey: Survey, cells: Cells, site: Site, whole: Cells) -> View:
    """What a station sees of some cells, where ``whole`` are those that its points are shared out over."""
    scanning = survey.scanning
    if survey.points_per_station is not None:
        spacing = spacing_for(whole, site, scanning, survey.points_per_station, survey.hidden)
        scanning = replace(scanning, spacing_rad=spacing)
    return look(cells, site, scanning, survey.errors, survey.hidden)


def sites_at(shaft: Shaft, azimuths_deg: Sequence[float], distance_m: float, up_m: float) -> tuple[Site, ...]:
    """Sites at azimuths as seen from the axis, at one horizontal distance from it; named ST01 and so on."""
    azimuths = np.radians(azimuths_deg)
    east, north = shaft.base_xy_m
    return tuple(
        Site(
            f"ST{i:02d}", (east + distance_m * float(np.sin(a)), north + distance_m * float(np.cos(a)), up_m)
        )
        for i, a in enumerate(azimuths, start=1)
    )


def _place(shaft: Shaft, site: Site) -> tuple[float, float]:
    """Azimuth as seen from the axis, degrees, and horizontal distance, metres."""
    east, north = np.subtract(site.position_m[:2], shaft.base_xy_m)
    return azimuth_deg(float(east), float(north)), float(np.hypot(east, north))
