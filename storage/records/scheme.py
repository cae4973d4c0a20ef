"""What became of a scheme in an epoch."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class SchemeRow:
    """A scheme and method of an epoch: whether it gave an axis, and if not, why."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    interval_m: Annotated[float | None, Column("distance between slices; NULL where it is not one", "m")]
    thickness_m: Annotated[
        float | None,
        Column("thickness of a slice, of slices that follow the points the least; NULL for none", "m"),
    ]
    contour: Annotated[str, Column("contour model of the slices")]
    axis: Annotated[str, Column("estimator of the axis")]
    n_slices: Annotated[int, Column("slices that were cut; bands of a whole surface")]
    n_centres: Annotated[int, Column("slices that gave a centre")]
    state: Annotated[str, Column("ok or failed")]
    reason: Annotated[str | None, Column("why the scheme gave no axis")]
