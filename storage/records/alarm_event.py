"""What happened to an alarm: append only."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True, kw_only=True)
class AlarmEventRow:
    """Something that happened to an alarm; the alarms themselves follow from their events."""

    event: Annotated[str, Column("id of the event; sorts by time")]
    structure: Annotated[str, Column("id of the structure")]
    alarm: Annotated[str, Column("id of the alarm that it happened to")]
    epoch: Annotated[
        str | None, Column("id of the epoch; NULL where the alarm is about none, as a missed campaign")
    ]
    rule: Annotated[str, Column("rule of the campaign file that was broken")]
    severity: Annotated[str, Column("info, warning or alarm")]
    action: Annotated[
        str,
        Column("raised, updated, eased, closed, acknowledged, muted, unmuted, delivered or delivery failed"),
    ]
    happened_at: Annotated[datetime, Column("when it happened", "UTC")]
    value: Annotated[float, Column("value that the rule looked at, in the unit of the rule")]
    limit_value: Annotated[float, Column("value that the rule allows, in the unit of the rule")]
    person: Annotated[str | None, Column("who did it; NULL where the program did")] = None
    note: Annotated[str | None, Column("what was said about it")] = None
    until: Annotated[datetime | None, Column("until when it is muted; NULL for good", "UTC")] = None
    unit: Annotated[
        str | None, Column("unit of value and limit_value, 1 for counts, ratios and statistics")
    ] = None
    about: Annotated[str | None, Column("of a delivery: id of the event that it told")] = None
    target: Annotated[str | None, Column("of a delivery: id of the target in [[notify]] that it went to")] = (
        None
    )
