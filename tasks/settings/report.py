"""The table [report]: which result counts."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from tasks.settings.section import Section

Method = Literal["paper", "robust", "surface"]

SchemeMethod = Annotated[tuple[str, Method], Field(strict=False)]
"""A scheme and a method, in this order."""


def _member(value: object) -> str:
    return "source" if isinstance(value, str) else "pair"


Control = Annotated[
    Annotated[SchemeMethod, Tag("pair")] | Annotated[str, Tag("source")], Discriminator(_member)
]
"""A scheme and a method, or the source of a reference measurement."""


class Report(Section):
    """Which scheme and method the verdict and the control come from."""

    primary: SchemeMethod = Field(
        default=("S", "surface"),
        description="scheme and method (paper, robust or surface) of the verdict and the alarms",
    )
    control: Control = Field(
        default=("F", "paper"),
        description="relative errors are counted against this: scheme and method, or the source of a reference",
    )
