"""The tables [[epochs]], [[epochs.stations]] and [[epochs.references]]: what was measured, when and from where."""

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, AwareDatetime, BeforeValidator, Field, model_validator

from tasks.settings.section import CONTROL, Line, SafeId, Section, Triple, problem

FIRST_YEAR, LAST_YEAR = 1960, 2200

LeanComponent = Annotated[float, Field(ge=-1.0, le=1.0)]
ScanPath = Annotated[Line, Field(min_length=1, max_length=1000)]


def _plausible(time: AwareDatetime) -> AwareDatetime:
    if not FIRST_YEAR <= time.year <= LAST_YEAR:
        raise problem(
            f"needs a year from {FIRST_YEAR} to {LAST_YEAR}, got {time.year}", "write the time of measuring"
        )
    return time


def _number_or_name(part: object) -> object:
    is_number = isinstance(part, int) and not isinstance(part, bool) and part >= 1
    if part is not None and not is_number and not (isinstance(part, str) and part.strip()):
        raise problem(f"needs the number of a scan, from 1, or its name, got {part!r}", 'write 2, or "NAME"')
    if isinstance(part, str) and CONTROL.search(part):
        raise problem(f"needs one line of plain text, got {part[:60]!r}", "name the scan by its number")
    return part


EpochTime = Annotated[AwareDatetime, AfterValidator(_plausible)]
"""A time of measuring, with its offset from UTC."""

Part = Annotated[
    Annotated[int, Field(ge=1)] | Annotated[str, Field(min_length=1, max_length=1000)] | None,
    BeforeValidator(_number_or_name),
]
"""Which scan of a file: its number from 1, or its name."""


class SetUp(Section):
    """Where a scanner stood and what its file holds; a station beside its id and its scan."""

    part: Part = Field(
        default=None,
        description="which scan of a file that holds several (E57, PTX): its number from 1, or its name",
    )
    pose: Literal["campaign", "file"] = Field(
        default="campaign",
        description="where position, heading and levelling are stated: by position_m and heading_deg, the scanner"
        " levelled; or by the scan file (E57, PTX), in the frame",
    )
    position_m: Triple | None = Field(
        default=None,
        description="scanner's centre in the order of frame.axes, before origin_m [m]; where it is missing, it is"
        " found from the shaft and the other stations",
    )
    heading_deg: Annotated[float, Field(ge=-360.0, le=360.0)] | None = Field(
        default=None,
        description="azimuth of the scanner's own +y axis, clockwise from grid north [deg]; where it is missing, it"
        " is found from the shaft and the other stations",
    )
    coordinates: Literal["cartesian", "polar"] = Field(
        default="cartesian",
        description="what the scan holds: x, y, z in the scanner's frame [m], or polar columns S [m],"
        " alpha, omega [deg] of eq. 1",
    )

    @model_validator(mode="after")
    def _one_pose(self) -> Self:
        if self.pose == "file" and (self.position_m is not None or self.heading_deg is not None):
            raise problem(
                'pose = "file" takes position and heading from the scan file, and they are stated here, too',
                "drop position_m and heading_deg, or drop pose",
            )
        return self


class Station(SetUp):
    """A set-up of the scanner in an epoch."""

    id: SafeId = Field(description="name of the station; unique in its epoch")
    scan: ScanPath = Field(description="file of the scan, relative to the campaign file")


class Reference(Section):
    """A lean that was measured by other means."""

    source: Line = Field(min_length=1, max_length=100, description="how it was measured; unique in its epoch")
    lean_east: LeanComponent = Field(description="east over up of the axis [1]")
    lean_north: LeanComponent = Field(description="north over up of the axis [1]")
    sigma: float = Field(gt=0.0, le=1.0, description="standard deviation of each component [1]")


class Epoch(Section):
    """A measuring campaign: stations, or one registered cloud instead."""

    id: SafeId = Field(description="name of the epoch; unique in the campaign")
    time: EpochTime = Field(description="time of measuring, with its offset from UTC")
    reference: bool = Field(
        default=False,
        description="changes are counted from this epoch; the earliest epoch where none says so",
    )
    stations: Annotated[tuple[Station, ...], Field(strict=False)] = Field(
        default=(), description="set-ups of the scanner"
    )
    registered: ScanPath | None = Field(
        default=None,
        description="file of one cloud that is in the frame already (origin_m and axes apply), instead of stations",
    )
    temperature_c: Annotated[float, Field(ge=-60.0, le=200.0)] | None = Field(
        default=None,
        description="temperature that the structure's movement may follow, of the air or the shaft [deg C]",
    )
    references: Annotated[tuple[Reference, ...], Field(strict=False)] = Field(
        default=(), description="leans measured by other means; may serve as control"
    )

    @property
    def scans(self) -> tuple[str, ...]:
        """Scan files of the epoch, as the file names them."""
        return (self.registered,) if self.registered else tuple(station.scan for station in self.stations)

    @model_validator(mode="after")
    def _stations_or_registered(self) -> Self:
        if self.stations and self.registered:
            raise problem("has both stations and a registered cloud", "keep one of the two")
        if not self.stations and not self.registered:
            raise problem(
                "has neither stations nor a registered cloud",
                'add [[epochs.stations]] tables, or registered = "FILE"',
            )
        return self
