"""What must hold between [limits] and the tables that it names."""

from collections.abc import Iterator

from tasks.limits import TABLES
from tasks.settings.campaign import Campaign
from tasks.settings.problems import Problem


def problems_of_limits(campaign: Campaign) -> Iterator[Problem]:
    """List names without a table, doubles, and limits of a measurement that would judge the lean."""
    limits, own = campaign.limits, {limit.name for limit in campaign.own_limits}
    known = ", ".join([*sorted(own), *sorted(TABLES)])
    named = [("table", limits.table)] if limits.table is not None else []
    for key, name in [*named, *(("also", name) for name in limits.also)]:
        if name not in own and name not in TABLES:
            yield Problem(f"limits.{key}", f"unknown table of limits {name!r}", f"known: {known}")
    doubles = sorted({name for name in limits.also if limits.also.count(name) > 1 or name == limits.table})
    if doubles:
        yield Problem("limits.also", f"names {', '.join(doubles)} twice", "name each table once")
    if limits.kind is not None and limits.verticality_m is None:
        yield Problem("limits.kind", "says what verticality_m is for, and there is none", "drop it")
    yield from _without_choice(campaign, own)
    yield from _of_measurement(campaign)


def _without_choice(campaign: Campaign, own: set[str]) -> Iterator[Problem]:
    limits = campaign.limits
    unnamed = own - set(limits.also)
    if limits.table is None and limits.verticality_m is None and len(unnamed) > 1:
        yield Problem(
            "limits.file",
            f"holds several tables: {', '.join(sorted(unnamed))}",
            "say with table which one counts, and with also which ones are judged beside it",
        )


def _of_measurement(campaign: Campaign) -> Iterator[Problem]:
    """List limits of a measurement as the primary limit: they judge how well one measured, not the structure."""
    limits, name = campaign.limits, campaign.primary_limit_name
    kinds = {limit.kind for limit in campaign.own_limits if limit.name == name}
    if limits.verticality_m is None and "measurement" in kinds:
        yield Problem(
            "limits.table",
            f"{name!r} is of kind measurement and judges the survey, not the lean",
            "name it in also",
        )
    if limits.verticality_m is not None and limits.kind == "measurement":
        yield Problem(
            "limits.kind", "a limit of the measurement judges the survey, not the lean", "put it into file"
        )
