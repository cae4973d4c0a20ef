"""The table [registration]: what beside GNSS ties stations and epochs together."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from tasks.settings.section import Line, Section, Triple, problem


class StableRegion(Section):
    """A box of surroundings that do not move between epochs."""

    name: Line = Field(min_length=1, max_length=100, description="what stands in the box; for messages")
    low_m: Triple = Field(
        description="its least coordinates, in the order of frame.axes, before origin_m [m]",
    )
    high_m: Triple = Field(
        description="its greatest coordinates, in the order of frame.axes, before origin_m [m]",
    )

    @model_validator(mode="after")
    def _low_below_high(self) -> Self:
        if any(low >= high for low, high in zip(self.low_m, self.high_m, strict=True)):
            raise problem(
                f"box {self.name!r} needs every number of low_m below that of high_m",
                "write the least coordinates into low_m",
            )
        return self


class Registration(Section):
    """How stations are tied to each other, and epochs to the reference epoch."""

    common_shaft: bool = Field(
        default=True,
        description="tie the stations of an epoch also by the one axis and radius profile that all of them see;"
        " for round structures; weighed lightly, and the level of every scanner is held all the same",
    )
    stable: Annotated[tuple[StableRegion, ...], Field(strict=False)] = Field(
        default=(),
        description="boxes of surroundings that do not move between epochs, none of them near the structure; their"
        " walls and grounds, as the reference epoch saw them, hold the other epochs beside GNSS",
    )
