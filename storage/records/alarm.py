"""An alarm."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class AlarmRow:
    """An alarm that was raised for an epoch."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    rule: Annotated[str, Column("rule of the campaign file that was broken")]
    severity: Annotated[str, Column("info, warning or alarm")]
    value: Annotated[float, Column("value that broke the rule, in the unit of the rule")]
    limit_value: Annotated[float, Column("value that the rule allows, in the unit of the rule")]
    state: Annotated[str, Column("new, acknowledged, muted or closed")]
    raised_at: Annotated[datetime, Column("when it was raised", "UTC")]
