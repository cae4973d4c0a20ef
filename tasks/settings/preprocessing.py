"""The table [preprocessing]: how the shaft is taken out of its surroundings."""

from pydantic import Field

from tasks.settings.section import Section


class Preprocessing(Section):
    """Options of the isolation of the shaft; the defaults are those of the stage."""

    voxel_m: float = Field(
        default=0.005,
        gt=0.0,
        le=5.0,
        description="a point is redundant where an earlier one lies in the same cube of this edge [m]",
    )
    gate_sigmas: float = Field(
        default=4.0,
        gt=0.0,
        le=100.0,
        description="points stay within so many robust sigmas of the surface, plus gate_radius_fraction [1]",
    )
    gate_radius_fraction: float = Field(
        default=0.005, ge=0.0, le=0.5, description="part of the radius that widens the gate on both sides [1]"
    )
    min_neighbours: int = Field(
        default=3, ge=0, le=1000, description="points with fewer neighbours on the surface are stray [points]"
    )
    most_points: int = Field(
        default=8_000_000,
        ge=100_000,
        le=1_000_000_000,
        description="of more points on the surface, duplicates counted, an even sample stays, one of 2, 3, ... of each "
        "scan; memory and time of all later stages follow it, about 100 bytes a point [points]",
    )
