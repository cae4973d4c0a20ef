"""What a planned survey scans: how finely, what hides the shaft, what the shaft is like."""

from typing import Annotated, Final, Self

from pydantic import Field, model_validator

from tasks.settings.cross_checks import FARTHEST_M
from tasks.settings.epochs import LeanComponent
from tasks.settings.schemes import SliceHeight
from tasks.settings.section import SafeId, Section, problem

SPACING_DEG: Final = 0.02
"""Taken where neither spacing_deg nor points_per_station is stated."""

Azimuth = Annotated[float, Field(ge=-360.0, le=360.0)]


class HiddenPart(Section):
    """A part of the shaft that something hides."""

    station: SafeId | None = Field(
        default=None, description="the station that it is hidden from; from all where it is missing"
    )
    azimuth_deg: Annotated[tuple[Azimuth, Azimuth], Field(strict=False)] | None = Field(
        default=None,
        description="sector of the shaft's surface that is hidden, from the first azimuth clockwise to the second,"
        " about the axis; all round where it is missing [deg]",
    )
    below_m: SliceHeight | None = Field(
        default=None, description="hidden below this height in the frame; at all heights where missing [m]"
    )

    @model_validator(mode="after")
    def _says_what(self) -> Self:
        if self.azimuth_deg is None and self.below_m is None:
            raise problem("hides the whole shaft", "write azimuth_deg, below_m or both")
        if self.azimuth_deg is not None and (self.azimuth_deg[1] - self.azimuth_deg[0]) % 360.0 == 0.0:
            raise problem("needs two azimuths that differ", "leave azimuth_deg out where all round is meant")
        return self


class ScanConditions(Section):
    """How finely a planned survey scans, what hides the shaft, and what the shaft is like."""

    spacing_deg: float | None = Field(
        default=None,
        ge=0.0005,
        le=5.0,
        description=f"step of the scanner in azimuth and elevation; {SPACING_DEG} where it is missing, too [deg]",
    )
    points_per_station: int | None = Field(
        default=None,
        ge=10,
        le=10_000_000_000,
        description="points of each station on the shaft, instead of spacing_deg [1]",
    )
    hidden: Annotated[tuple[HiddenPart, ...], Field(strict=False)] = Field(
        default=(), description="what stands between stations and the shaft"
    )
    incidence_limit_deg: float = Field(
        default=80.0,
        gt=0.0,
        lt=90.0,
        description="no points at an incidence above this, from the normal [deg]",
    )
    reach_m: float | None = Field(
        default=None, gt=0.0, le=FARTHEST_M, description="reach of the scanner; without end where missing [m]"
    )
    roughness_m: float = Field(
        default=0.003, ge=0.0, le=1.0, description="standard deviation of the surface, point to point [m]"
    )
    form_m: float = Field(
        default=0.0,
        ge=0.0,
        le=1.0,
        description="standard deviation by which patches of 5 m by 10 deg are off a circle; 0: a round shaft [m]",
    )
    lean: Annotated[tuple[LeanComponent, LeanComponent], Field(strict=False)] = Field(
        default=(0.0, 0.0), description="lean that is expected, east and north over up [1]"
    )

    @model_validator(mode="after")
    def _one_way_to_count(self) -> Self:
        if self.spacing_deg is not None and self.points_per_station is not None:
            raise problem("has both spacing_deg and points_per_station", "keep one of the two")
        return self
