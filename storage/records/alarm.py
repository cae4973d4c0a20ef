"""An alarm."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class AlarmRow:
    """An alarm: a rule of the campaign file, from its raising until it is closed.

    While ``eased_at`` is NULL, the rule is broken still. One that has eased stays ``new`` until a person acknowledges
    or closes it.
    """

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[
        str | None,
        Column("epoch that value is of; NULL where the alarm is about none, as a missed campaign"),
    ]
    rule: Annotated[str, Column("rule of the campaign file that was broken")]
    severity: Annotated[str, Column("info, warning or alarm")]
    value: Annotated[float, Column("value when the rule was looked at last, in the unit of the rule")]
    limit_value: Annotated[float, Column("value that the rule allows, in the unit of the rule")]
    state: Annotated[str, Column("new, acknowledged, muted or closed")]
    raised_at: Annotated[datetime, Column("when it was raised", "UTC")]
    alarm: Annotated[str, Column("id of the alarm")]
    changed_at: Annotated[datetime, Column("when anything last happened to it", "UTC")]
    person: Annotated[str | None, Column("who acknowledged, muted or closed it; NULL where nobody did")]
    note: Annotated[str | None, Column("what a person, or the program when it closed it, said last")]
    muted_until: Annotated[
        datetime | None, Column("until when it is muted; NULL where it is not, or for good", "UTC")
    ]
    unit: Annotated[str | None, Column("unit of value and limit_value, 1 for counts, ratios and statistics")]
    what: Annotated[str | None, Column("what the rule found, in words")]
    raised_epoch: Annotated[
        str | None, Column("epoch that it was raised at; NULL where the alarm is about none")
    ]
    eased_at: Annotated[
        datetime | None, Column("when the value was found back within its limit; NULL while it is not", "UTC")
    ]
