"""What one limit says of one axis."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class VerdictRow:
    """What one of the limits of a campaign says of an axis: all of them side by side, each with its papers."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    limit_name: Annotated[str, Column("name of the table of limits")]
    is_primary: Annotated[bool, Column("whether the verdict in tilt comes from this limit")]
    version: Annotated[
        int | None, Column("version of the table; NULL where none holds at the time of the epoch")
    ]
    kind: Annotated[
        str | None,
        Column("construction, design, in-service, measurement or unstated; NULL without a version"),
    ]
    document: Annotated[str | None, Column("where the limit stands; NULL without a version")]
    edition: Annotated[str | None, Column("edition of the document; NULL without a version")]
    clause: Annotated[str | None, Column("clause of the document; NULL without a version")]
    height_m: Annotated[float, Column("height H at which the deviation is stated", "m")]
    allowable_m: Annotated[
        float | None,
        Column(
            "allowable deviation at height_m, of kind measurement the allowable uncertainty; NULL without a limit there",
            "m",
        ),
    ]
    deviation_m: Annotated[float, Column("height_m times the tangent of the tilt", "m")]
    sigma_m: Annotated[
        float | None, Column("standard deviation of deviation_m; NULL without a covariance", "m")
    ]
    verdict: Annotated[str, Column("pass, fail, cannot tell or no limit")]
    reason: Annotated[str, Column("figures, limit, kind and standing of the verdict")]
