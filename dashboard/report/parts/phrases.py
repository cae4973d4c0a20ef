"""Phrases that several chapters need."""

import math
from typing import Final

from dashboard import numbers
from dashboard.report.facts import Facts
from dashboard.report.words import Words
from storage.records import TrendRow, VerdictRow
from storage.views import ChangeRow

POINTS: Final = ("n", "ne", "e", "se", "s", "sw", "w", "nw")

BRIEF: Final = 280

SEPARATOR: Final = {"en": ", ", "zh": "，"}


def compass(azimuth_deg: float, words: Words) -> str:
    """Name the nearest of eight points of the compass."""
    return words(f"compass.{POINTS[round(azimuth_deg / 45.0) % 8]}")


def movement_azimuth(change: ChangeRow, words: Words) -> str | None:
    """Whither the top moved; None where the movement is not significant, which has no direction."""
    if not change.significant:
        return None
    azimuth = math.degrees(math.atan2(change.d_lean_east, change.d_lean_north)) % 360.0
    return words("phrase.towards", compass=compass(azimuth, words), azimuth=numbers.degrees(azimuth, 0))


def limit_title(verdict: VerdictRow | None, words: Words) -> str:
    """Document, edition, clause and kind of a limit."""
    if verdict is None or verdict.document is None:
        return words("phrase.limit_unknown")
    parts = [verdict.document, verdict.edition or "", verdict.clause or ""]
    kind = words.named("kind", verdict.kind or "unstated")
    return SEPARATOR[words.lang].join([*(part for part in parts if part), kind])


def limit_date(trend: TrendRow, words: Words) -> str:
    """When the limit is reached at the present rate, with the range of 95 %."""
    if trend.limit_m is None:
        return words("trend.no_limit")
    if trend.limit_reached_at is None:
        return words("trend.never")
    if trend.limit_reached_at <= trend.last_time:
        return words("trend.already")
    latest = words("trend.open") if trend.limit_latest_at is None else numbers.day(trend.limit_latest_at)
    return words(
        "trend.reached",
        date=numbers.day(trend.limit_reached_at),
        earliest=numbers.day(trend.limit_earliest_at),
        latest=latest,
    )


def brief(text: str) -> str:
    """Cut a long reason; the chapter on quality has all of it."""
    return text if len(text) <= BRIEF else f"{text[: BRIEF - 1]}…"


def p_value(value: float | None) -> str:
    """Write a probability with its name."""
    text = numbers.probability(value)
    return f"p {text}" if text.startswith("<") else f"p = {text}"


def way(scheme: str, method: str) -> str:
    """Name a scheme and method."""
    return f"{scheme}/{method}"


def no_tilt_reason(facts: Facts, words: Words) -> str:
    """Why the epoch has no result under the primary scheme and method."""
    failed = [row for row in facts.schemes if (row.scheme, row.method) == facts.primary and row.reason]
    if failed:
        return str(failed[0].reason)
    return facts.epoch.reason or words("phrase.no_reason")
