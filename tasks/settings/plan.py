"""A plan file: the structure, the instrument, and the table [plan] of a survey that nobody has measured yet."""

from itertools import combinations
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from tasks.methods import methods_of
from tasks.settings.cross_checks import FARTHEST_M
from tasks.settings.frame import Frame
from tasks.settings.instrument import Instrument
from tasks.settings.plan_conditions import Azimuth, ScanConditions
from tasks.settings.problems import nearest
from tasks.settings.report import Report, SchemeMethod
from tasks.settings.schemes import SliceHeight
from tasks.settings.section import SafeId, Section, Triple, problem
from tasks.settings.structure import Structure
from tasks.slicing import SCHEMES


def _known_pair(primary: SchemeMethod) -> SchemeMethod:
    scheme, method = primary
    if scheme not in SCHEMES:
        raise problem(f"unknown scheme {scheme!r}", nearest(scheme, sorted(SCHEMES)))
    known = [one.name for one in methods_of(SCHEMES[scheme])]
    if method not in known:
        raise problem(
            f"scheme {scheme!r} has no method {method!r}", f"{scheme} goes with {' or '.join(known)}"
        )
    return primary


class PlanStation(Section):
    """A station that is planned."""

    id: SafeId = Field(description="name of the station; unique in the plan")
    position_m: Triple = Field(
        description="scanner's centre in the order of frame.axes, before origin_m [m]",
    )


class Plan(ScanConditions):
    """Where the scanner is to stand, how finely it scans, and what the shaft is like."""

    stations: Annotated[tuple[PlanStation, ...], Field(strict=False)] = Field(
        default=(), description="stations, one by one; instead of count or azimuths_deg, and distance_m"
    )
    count: int | None = Field(
        default=None, ge=1, le=100, description="number of stations, evenly around the structure [1]"
    )
    first_azimuth_deg: Azimuth = Field(
        default=0.0, description="azimuth of the first of count stations, seen from the axis [deg]"
    )
    azimuths_deg: Annotated[tuple[Azimuth, ...], Field(strict=False, min_length=1, max_length=100)] | None = (
        Field(
            default=None, description="azimuths of the stations, seen from the axis, instead of count [deg]"
        )
    )
    distance_m: float | None = Field(
        default=None,
        gt=0.0,
        le=FARTHEST_M,
        description="horizontal distance of count or azimuths_deg stations from the axis [m]",
    )
    up_m: SliceHeight = Field(
        default=1.6, description="height of their scanners in the frame, after origin_m was subtracted [m]"
    )

    primary: Annotated[SchemeMethod, AfterValidator(_known_pair)] = Field(
        default=Report().primary,
        description="scheme and method that the lean will come from: its slices, or the whole surface",
    )

    @model_validator(mode="after")
    def _one_way_to_place(self) -> Self:
        ways = [bool(self.stations), self.count is not None, self.azimuths_deg is not None]
        if sum(ways) != 1:
            raise problem(
                f"needs one of stations, count and azimuths_deg, got {sum(ways)}",
                "write count = 8 and distance_m, or a table [[plan.stations]] for each station",
            )
        if bool(self.stations) == (self.distance_m is not None):
            what = "stations have their own positions" if self.stations else "needs distance_m"
            raise problem(what, "drop distance_m" if self.stations else "write the distance from the axis")
        return self

    @model_validator(mode="after")
    def _names_are_clear(self) -> Self:
        for first, second in combinations(self.station_ids, 2):
            if first.casefold() == second.casefold():
                raise problem(f"station id {second!r} is taken", "choose another")
        for part in self.hidden:
            if part.station is not None and part.station not in self.station_ids:
                hint = nearest(part.station, self.station_ids)
                raise problem(f"hidden names an unknown station {part.station!r}", hint)
        return self

    @property
    def station_ids(self) -> tuple[str, ...]:
        """Ids of the stations; those that are not named one by one are ST01 and so on."""
        if self.stations:
            return tuple(station.id for station in self.stations)
        n = self.count or len(self.azimuths_deg or ())
        return tuple(f"ST{i:02d}" for i in range(1, n + 1))

    @property
    def ring_azimuths_deg(self) -> tuple[float, ...]:
        """Azimuths of the stations that are not named one by one."""
        if self.azimuths_deg is not None:
            return self.azimuths_deg
        n = self.count or 0
        return tuple(self.first_azimuth_deg + 360.0 * i / n for i in range(n))


class PlanFile(Section):
    """A survey to come: ``tiltwatch plan`` predicts what it will give."""

    schema_version: Literal[1] = Field(description="version of this file's form; 1")
    structure: Structure = Field(description="what is to be watched")
    frame: Frame = Field(
        default=Frame(axes="ENU"), description="what coordinates mean; local and ENU where it is missing"
    )
    instrument: Instrument = Field(default=Instrument(), description="what the maker of the scanner states")
    plan: Plan = Field(description="stations, spacing and what hides the shaft")
