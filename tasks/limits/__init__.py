"""Limits: allowable deviations as data, one file a table, and the verdict on a deviation."""

from typing import Final

from tasks.geometry.variants import choose, discover
from tasks.limits.guard_band import Verdict, verdict
from tasks.limits.table import (
    LimitKind,
    LimitPoint,
    LimitTable,
    MissingLimit,
    PointsRule,
    RatioRule,
    allowable,
    table_of_points,
)

TABLES: Final = discover(__name__, "TABLE", LimitTable)
"""The shipped tables by name."""


def table_named(name: str) -> LimitTable:
    """Shipped table of that name.

    Raises
    ------
    InputError
        If there is none; the message lists the known names.
    """
    return choose(TABLES, name, "limit table")


__all__ = [
    "TABLES",
    "LimitKind",
    "LimitPoint",
    "LimitTable",
    "MissingLimit",
    "PointsRule",
    "RatioRule",
    "Verdict",
    "allowable",
    "table_named",
    "table_of_points",
    "verdict",
]
