"""From a plan file or a campaign file to a survey design: what is predicted before anybody goes out."""

from dataclasses import dataclass, replace
from math import hypot
from typing import Final

import numpy as np

from storage.errors import InputError
from tasks.design import (
    Bands,
    Errors,
    Hidden,
    Levels,
    Scanning,
    Shaft,
    Site,
    Survey,
    sites_at,
    slices,
    whole_surface,
)
from tasks.methods import method_of
from tasks.plan import plan_axes
from tasks.settings import Campaign, Epoch
from tasks.settings.cross_checks import FARTHEST_M
from tasks.settings.frame import Frame
from tasks.settings.instrument import Instrument
from tasks.settings.plan import PlanFile
from tasks.settings.plan_conditions import SPACING_DEG, ScanConditions
from tasks.settings.structure import Structure
from tasks.slicing import SCHEMES, SlicingScheme, slice_heights

VERTEX_MEAN: Final = "F"
"""Name of the scheme whose centres no fit gives."""


@dataclass(frozen=True, slots=True)
class Design:
    """A survey to predict, and what it is called: the structure, the epoch whose stations it takes, scheme and method."""

    title: str
    height_m: float
    epoch: str | None
    primary: tuple[str, str]
    survey: Survey

    @property
    def uses_all_points(self) -> bool:
        """Whether the lean will come from the whole height, and not from slices."""
        return float(self.survey.bands.thickness_m.sum()) > 0.99 * self.survey.shaft.length_m


def design_survey(file: PlanFile | Campaign, epoch: str | None = None) -> Design:
    """Put together the survey that a file states.

    Of a campaign the stations of an epoch are taken: of the one named, else of the latest that states the position of
    every station. What a campaign file does not state (spacing, roughness) has the default of [plan].

    Raises
    ------
    InputError
        If the structure is not round, the scheme cannot be planned, no epoch states where its stations stand, or one
        of them stands in the shaft.
    """
    _check_kind(file.structure)
    design = _planned(file) if isinstance(file, PlanFile) else _repeated(file, epoch)
    _check_distances(design.survey)
    return design


def survey_of_sites(campaign: Campaign, sites: tuple[Site, ...]) -> Survey:
    """Put together the survey of a campaign's structure from stations at these sites.

    What a campaign file does not state (spacing, roughness) has the default of [plan].

    Raises
    ------
    InputError
        If the structure is not round, the scheme cannot be planned, or a station stands in the shaft.
    """
    _check_kind(campaign.structure)
    survey = _usual_survey(campaign, sites)
    _check_distances(survey)
    return survey


def with_points(design: Design, points_per_station: int) -> Design:
    """Let every station lay so many points on the shaft, in place of what the file states."""
    return replace(design, survey=replace(design.survey, points_per_station=points_per_station))


def _planned(file: PlanFile) -> Design:
    plan = file.plan
    shaft = _shaft(file.structure, file.frame, plan.lean)
    sites = tuple(
        Site(station.id, file.frame.site_position_m(station.position_m)) for station in plan.stations
    )
    if plan.distance_m is not None:
        sites = sites_at(shaft, plan.ring_azimuths_deg, plan.distance_m, plan.up_m)
    bands = _bands(SCHEMES[plan.primary[0]], plan.primary[1], shaft)
    scanning, errors = _scanner(file.instrument, plan)
    errors = replace(errors, levels=_levels(SCHEMES[plan.primary[0]]))
    survey = _survey(Survey(shaft, bands, sites, scanning, errors), plan)
    return Design(file.structure.title, file.structure.height_m, None, plan.primary, survey)


def _repeated(file: Campaign, epoch: str | None) -> Design:
    taken = _stated_epoch(file, epoch)
    sites = tuple(
        Site(station.id, file.frame.site_position_m(station.position_m))
        for station in taken.stations
        if station.position_m is not None
    )
    primary = file.report.primary
    survey = _usual_survey(file, sites)
    return Design(file.structure.title, file.structure.height_m, taken.id, primary, survey)


def _usual_survey(campaign: Campaign, sites: tuple[Site, ...]) -> Survey:
    usual, primary = ScanConditions(), campaign.report.primary
    shaft = _shaft(campaign.structure, campaign.frame, usual.lean)
    scheme = plan_axes(campaign, primary[:1])[0].scheme
    bands = _bands(scheme, primary[1], shaft)
    scanning, errors = _scanner(campaign.instrument, usual)
    errors = replace(errors, levels=_levels(scheme))
    return _survey(Survey(shaft, bands, sites, scanning, errors), usual)


def _check_kind(structure: Structure) -> None:
    if structure.kind == "square-tower":
        raise InputError("a plan needs a round shaft, structure.kind is 'square-tower'")


def _levels(scheme: SlicingScheme) -> Levels:
    """A fit of the whole surface adjusts the levels along; slices take them as they are."""
    return "held" if scheme.surface is None else "adjusted"


def _stated_epoch(campaign: Campaign, wanted: str | None) -> Epoch:
    if wanted is not None:
        epoch = campaign.epoch(wanted)
        if epoch is None:
            known = ", ".join(one.id for one in campaign.epochs)
            raise InputError(f"unknown epoch {wanted!r}; known: {known}")
        if not _states_positions(epoch):
            lacking = [station.id for station in epoch.stations if station.position_m is None]
            raise InputError(
                f"a plan needs position_m of every station, epoch {wanted} lacks "
                + (", ".join(lacking) or "stations: it comes as one registered cloud")
            )
        return epoch
    stated = [epoch for epoch in campaign.epochs if _states_positions(epoch)]
    if not stated:
        raise InputError(
            "a plan needs an epoch that states position_m of every station, this campaign has none; "
            "write a file with a table [plan]"
        )
    return max(stated, key=lambda one: one.time)


def _states_positions(epoch: Epoch) -> bool:
    return bool(epoch.stations) and all(station.position_m is not None for station in epoch.stations)


def _shaft(structure: Structure, frame: Frame, lean: tuple[float, float]) -> Shaft:
    first, second = structure.base_xy_m
    base_xy_m = (second, first) if frame.swaps_axes else (first, second)
    return Shaft(structure.shaft_z_m, structure.radius_m, base_xy_m, lean)


def _bands(scheme: SlicingScheme, method: str, shaft: Shaft) -> Bands:
    """Where the points are taken from; slices that follow the points leave no height out."""
    if scheme.name == VERTEX_MEAN:
        raise InputError(
            f"a plan needs centres that are fitted, scheme {scheme.name} takes means of vertices"
        )
    if scheme.surface is not None or scheme.adaptive is not None:
        return whole_surface(shaft)
    heights_m = slice_heights(scheme, shaft.z_m)
    if len(heights_m) < 2:
        raise InputError(f"scheme {scheme.name} needs 2 slices for an axis, shaft_z_m has room for fewer")
    thickness_m = min(method_of(scheme, method).thickness_m, float(np.diff(heights_m).min()))
    return slices(heights_m, thickness_m)


def _scanner(instrument: Instrument, conditions: ScanConditions) -> tuple[Scanning, Errors]:
    scanning = Scanning(
        spacing_rad=float(np.radians(conditions.spacing_deg or SPACING_DEG)),
        incidence_limit_rad=float(np.radians(conditions.incidence_limit_deg)),
        reach_m=conditions.reach_m or np.inf,
    )
    errors = Errors(
        range_m=instrument.range_sigma_m,
        angle_rad=float(np.radians(instrument.angle_sigma_deg)),
        level_rad=float(np.radians(instrument.level_sigma_deg)),
        position_m=instrument.position_sigma_m,
        heading_rad=float(np.radians(instrument.heading_sigma_deg)),
        roughness_m=conditions.roughness_m,
        form_m=conditions.form_m,
    )
    return scanning, errors


def _survey(survey: Survey, conditions: ScanConditions) -> Survey:
    """Add what hides the shaft, and how many points are wanted."""
    hidden = tuple(Hidden(part.station, part.azimuth_deg, part.below_m) for part in conditions.hidden)
    return replace(survey, hidden=hidden, points_per_station=conditions.points_per_station)


def _check_distances(survey: Survey) -> None:
    base, largest_m = survey.shaft.base_xy_m, max(survey.shaft.radius_m)
    for site in survey.sites:
        away_m = hypot(site.position_m[0] - base[0], site.position_m[1] - base[1])
        if not largest_m < away_m <= FARTHEST_M:
            raise InputError(
                f"station {site.station} stands {away_m:g} m from the axis, the shaft has a radius of {largest_m:g} m and "
                f"no scanner sees farther than {FARTHEST_M:g} m; check its position, frame.origin_m and base_xy_m"
            )
