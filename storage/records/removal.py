"""What preprocessing removed, and why."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class RemovalRow:
    """Points of an epoch that were removed for one reason."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    step: Annotated[int, Column("order in which the reasons were applied, from 0")]
    reason: Annotated[str, Column("why the points were removed; 'kept' for those that remained")]
    n_points: Annotated[int, Column("points")]
