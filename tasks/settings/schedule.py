"""The table [schedule]: when the campaign is processed without anybody asking, and what guards such a run."""

import re
from typing import Annotated, Final
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from pydantic import AfterValidator, Field

from tasks.settings.section import Section, problem

DAY_S: Final = 86_400.0

MONTHS: Final = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
DAYS: Final = ("sun", "mon", "tue", "wed", "thu", "fri", "sat")

CRON_FIELDS: Final = (
    ("minute", 0, 59, ()),
    ("hour", 0, 23, ()),
    ("day of the month", 1, 31, ()),
    ("month", 1, 12, MONTHS),
    ("day of the week", 0, 7, DAYS),
)
"""Name, lowest and highest value of each field, and the names that stand for values from the lowest on."""

CRON_ITEM: Final = re.compile(r"(?:\*|(\w+)(?:-(\w+))?)(?:/([1-9]\d?))?")


def _cron(text: str) -> str:
    fields = text.split()
    if len(fields) != len(CRON_FIELDS):
        raise problem(
            f"needs five fields (minute, hour, day, month, day of the week), got {len(fields)}",
            'for every morning at half past six: "30 6 * * *"',
        )
    for field, (name, low, high, names) in zip(fields, CRON_FIELDS, strict=True):
        if not all(_is_cron_item(item, low, high, names) for item in field.split(",")):
            raise problem(
                f"the {name} {field!r} is none", f"needed: *, numbers {low} to {high}, 1-5, */2, 1,15"
            )
    return " ".join(fields)


def _is_cron_item(item: str, low: int, high: int, names: tuple[str, ...]) -> bool:
    found = CRON_ITEM.fullmatch(item)
    if found is None:
        return False
    ends = [_cron_value(end, low, names) for end in found.groups()[:2] if end is not None]
    return all(end is not None and low <= end <= high for end in ends) and (
        len(ends) < 2 or ends == sorted(ends, key=lambda end: end or 0)
    )


def _cron_value(text: str, low: int, names: tuple[str, ...]) -> int | None:
    if text.lower() in names:
        return names.index(text.lower()) + low
    return int(text) if text.isascii() and text.isdecimal() else None


def _zone(name: str) -> str:
    try:
        ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError) as error:
        raise problem(
            f"{name!r} is no time zone", "write it as in the IANA list, for example Europe/Berlin"
        ) from error
    return name


class Schedule(Section):
    """When a deployed campaign is processed, and how long and how often it is tried."""

    cron: Annotated[str, AfterValidator(_cron)] | None = Field(
        default=None,
        description="when it is processed: minute, hour, day, month, day of the week;"
        " only on request where missing",
    )
    timezone: Annotated[str, AfterValidator(_zone)] = Field(
        default="UTC", description="time zone of cron, as in the IANA list"
    )
    active: bool = Field(default=True, description="whether the schedule counts; false pauses it")
    interval_days: float | None = Field(
        default=None,
        gt=0.0,
        le=3660.0,
        description="longest time between epochs before a campaign counts as missed [d]",
    )
    time_limit_s: float = Field(
        default=4 * 3600.0,
        ge=10.0,
        le=7 * DAY_S,
        description="longest time that an epoch of a deployed run may take, native code included [s]",
    )
    retries: int = Field(
        default=1,
        ge=0,
        le=20,
        description="how often an epoch of a deployed run that met a fault or its limit is tried again",
    )
    retry_delay_s: float = Field(
        default=60.0, ge=0.0, le=DAY_S, description="pause before it is tried again [s]"
    )
