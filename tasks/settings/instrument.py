"""The table [instrument]: what the maker of the scanner states."""

from typing import Annotated

from pydantic import Field

from tasks.settings.section import Section

PositionSigma = Annotated[float, Field(gt=0.0, le=10.0)]


class Instrument(Section):
    """Standard deviations of scanner and set-up: the priors of the adjustment."""

    range_sigma_m: float = Field(
        default=0.005, gt=0.0, le=1.0, description="standard deviation of a range at 100 m [m]"
    )
    angle_sigma_deg: float = Field(
        default=0.001,
        gt=0.0,
        le=1.0,
        description="standard deviation of a horizontal or vertical angle [deg]",
    )
    level_sigma_deg: float = Field(
        default=0.0008, gt=0.0, le=5.0, description="standard deviation of one component of the level [deg]"
    )
    position_sigma_m: Annotated[tuple[PositionSigma, PositionSigma], Field(strict=False)] = Field(
        default=(0.015, 0.0225),
        description="standard deviation of a station's position by GNSS, horizontal and vertical [m]",
    )
    heading_sigma_deg: float = Field(
        default=0.15, gt=0.0, le=180.0, description="standard deviation of a station's heading [deg]"
    )
