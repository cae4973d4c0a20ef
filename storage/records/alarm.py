"""An alarm."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class AlarmRow:
    """An alarm that was raised for an epoch."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[
        str | None, Column("id of the epoch; NULL where the alarm is about none, as a missed campaign")
    ]
    rule: Annotated[str, Column("rule of the campaign file that was broken")]
    severity: Annotated[str, Column("info, warning or alarm")]
    value: Annotated[float, Column("value that broke the rule, in the unit of the rule")]
    limit_value: Annotated[float, Column("value that the rule allows, in the unit of the rule")]
    state: Annotated[str, Column("new, acknowledged, muted or closed")]
    raised_at: Annotated[datetime, Column("when it was raised", "UTC")]
    alarm: Annotated[str, Column("id of the alarm")]
    changed_at: Annotated[datetime, Column("when anything last happened to it", "UTC")]
    person: Annotated[str | None, Column("who acknowledged, muted or closed it; NULL where nobody did")]
    note: Annotated[str | None, Column("what was said about it last")]
    muted_until: Annotated[
        datetime | None, Column("until when it is muted; NULL where it is not, or for good", "UTC")
    ]
