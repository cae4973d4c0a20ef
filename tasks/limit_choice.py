"""Which limits an epoch is judged by: shipped tables, or those of a user's file in the version of its time."""

from collections.abc import Iterator, Sequence
from datetime import datetime

from tasks.limits import (
    TABLES,
    LimitKind,
    LimitPoint,
    LimitTable,
    MissingLimit,
    PointsRule,
    RatioRule,
    table_named,
    table_of_points,
)
from tasks.settings import Campaign
from tasks.settings.limit_file import StatedLimit


def primary_limit(campaign: Campaign, when: datetime) -> LimitTable | MissingLimit | None:
    """The limit that gives the verdict of an epoch: own points win over a table; None where there is neither."""
    limits = campaign.limits
    if limits.verticality_m is not None:
        kind = LimitKind.UNSTATED if limits.kind is None else LimitKind(limits.kind)
        return table_of_points(limits.verticality_m, kind)
    name = campaign.primary_limit_name
    return None if name is None else _limit(campaign.own_limits, name, when)


def further_limits(campaign: Campaign, when: datetime) -> tuple[LimitTable | MissingLimit, ...]:
    """The limits that an epoch is judged by beside the primary one, in the order of the file."""
    return tuple(_limit(campaign.own_limits, name, when) for name in campaign.limits.also)


def own_tables(stated: Sequence[StatedLimit]) -> Iterator[LimitTable]:
    """Every version of every table of a user's file."""
    for limit in stated:
        yield _table(limit)


def _limit(own: Sequence[StatedLimit], name: str, when: datetime) -> LimitTable | MissingLimit:
    """A table by name, in the newest version that was valid on the day of the epoch, in the time zone of its time.

    Raises
    ------
    InputError
        If there is no such table.
    """
    versions = [limit for limit in own if limit.name == name]
    if name in TABLES or not versions:
        return table_named(name)
    day = when.date()
    valid = [limit for limit in versions if limit.valid_from is None or limit.valid_from <= day]
    if not valid:
        first = min(limit.valid_from for limit in versions if limit.valid_from is not None)
        return MissingLimit(name, f"no version holds on {day}; the first is valid from {first}")
    return _table(max(valid, key=lambda limit: (limit.valid_from is not None, limit.valid_from)))


def _table(limit: StatedLimit) -> LimitTable:
    return LimitTable(
        name=limit.name,
        version=limit.version,
        rule=_rule(limit),
        kind=LimitKind(limit.kind),
        document=limit.document,
        edition=limit.edition,
        clause=limit.clause,
        source=limit.source,
        verified_by=limit.verified_by,
        note=limit.note,
        valid_from=None if limit.valid_from is None else limit.valid_from.isoformat(),
        sigmas=limit.sigmas,
    )


def _rule(limit: StatedLimit) -> PointsRule | RatioRule:
    if limit.points_m is not None:
        return PointsRule(tuple(LimitPoint(height_m, value_m) for height_m, value_m in limit.points_m))
    return RatioRule(
        ratio=limit.share,
        above_m=limit.above_m,
        largest_m=limit.at_most_m,
        least_m=limit.at_least_m,
        up_to_m=limit.up_to_m,
    )
