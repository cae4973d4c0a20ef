"""The table [frame]: what the coordinates of the campaign mean."""

import re
from typing import Annotated, Final, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from tasks.settings.section import Section, Triple, problem

HORIZONTAL: Final = re.compile(r"local|EPSG:[0-9]{4,6}")

IN_DEGREES: Final = frozenset({4214, 4258, 4267, 4269, 4326, 4480, 4490, 4610, 4937, 4979})
"""EPSG codes of the common systems of latitude and longitude: no metres, so no frame for a lean."""


def _horizontal(value: object) -> object:
    if isinstance(value, int) and not isinstance(value, bool):
        value = f"EPSG:{value}"
    if not isinstance(value, str):
        return value
    name = value.strip().upper() if value.strip().lower().startswith("epsg:") else value.strip()
    if not HORIZONTAL.fullmatch(name):
        raise problem(
            f"needs 'local' or an EPSG code, got {value!r}", 'write "local" or, for example, "EPSG:32650"'
        )
    if name != "local" and int(name[5:]) in IN_DEGREES:
        raise problem(f"{name} counts in degrees; a frame needs metres", "use a projected system")
    return name


class Frame(Section):
    """What x, y, z of the campaign mean.

    ``axes`` and ``origin_m`` apply to everything that is written in the frame of the site: ``position_m`` of
    stations, positions that scan files state (pose = "file"), ``base_xy_m`` (axes only), the boxes of stable
    surroundings and the points of ``registered`` clouds. They do not apply to scans of stations, whose points are in
    the scanner's own frame, nor to keys that name their direction themselves (``lean_east``, ``heading_deg``).
    """

    axes: Literal["ENU", "NEU"] = Field(
        description="order of the coordinates of positions and registered clouds: ENU (east, north, up) or"
        " NEU (north, east, up); there is no default, because a wrong guess mirrors the azimuth"
    )
    horizontal: Annotated[str, BeforeValidator(_horizontal)] = Field(
        default="local", description="'local', or 'EPSG:n' of a projected system in metres, with origin_m"
    )
    origin_m: Triple = Field(
        default=(0.0, 0.0, 0.0),
        description="subtracted from positions and registered clouds before any work, in the order of axes [m]",
    )

    @property
    def swaps_axes(self) -> bool:
        """Whether the first two coordinates change places on the way to east, north, up."""
        return self.axes == "NEU"

    @property
    def origin_enu_m(self) -> tuple[float, float, float]:
        """Origin as east, north, up [m]."""
        return self._east_first(self.origin_m)

    def site_position_m(self, position_m: tuple[float, float, float]) -> tuple[float, float, float]:
        """East, north, up in the site frame of a position as the file has it [m]."""
        x, y, z = (value - origin for value, origin in zip(position_m, self.origin_m, strict=True))
        return self._east_first((x, y, z))

    def _east_first(self, triple: tuple[float, float, float]) -> tuple[float, float, float]:
        first, second, up = triple
        return (second, first, up) if self.swaps_axes else triple

    @model_validator(mode="after")
    def _grid_needs_origin(self) -> Self:
        if self.horizontal != "local" and "origin_m" not in self.model_fields_set:
            raise problem(
                f"horizontal {self.horizontal!r} needs origin_m",
                "write the grid coordinates of a point near the foot of the structure, in the order of axes",
            )
        return self
