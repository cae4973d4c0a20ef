"""One quantity of one scheme against the control."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class AccuracyRow:
    """One quantity of one scheme and method against the control scheme or a control measurement."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    control: Annotated[
        str, Column("what it is compared with: scheme/method, or the source of a reference measurement")
    ]
    quantity: Annotated[str, Column("beta_deg, azimuth_deg, tilt_deg, verticality_permille or deviation_m")]
    value: Annotated[float, Column("value under this scheme and method, in the unit of the quantity's name")]
    reference: Annotated[float, Column("value of the control")]
    difference: Annotated[float, Column("value minus reference; azimuths by the shorter way round")]
    relative_error_pct: Annotated[
        float | None, Column("eq. 23; NULL for azimuth_deg, where it has no meaning", "pct")
    ]
    reference_sigma: Annotated[
        float | None,
        Column("standard deviation of reference, in its unit; NULL where unknown, and for beta_deg"),
    ] = None
