"""The state of a structure as lines for people and as an object for programs."""

from collections.abc import Iterator, Sequence
from datetime import datetime
from typing import Final

from flows.terminal import Json
from storage.records import EpochRow, VerdictRow
from storage.views.condition import Condition, Level
from tasks.geometry.probability_text import p_text

EXIT_CODES: Final = {Level.OK: 0, Level.QUALITY: 4, Level.WARNING: 5, Level.ALARM: 6}

NAMES: Final = {
    Level.OK: "ok",
    Level.QUALITY: "quality gate not passed",
    Level.WARNING: "warning",
    Level.ALARM: "alarm",
}


def lines_of(condition: Condition, now: datetime) -> Iterator[str]:
    """State of an epoch, a line a question."""
    epoch = condition.epoch
    measured = f"{epoch.epoch_time:%Y-%m-%d %H:%M %Z}, {_age(epoch.epoch_time, now)}"
    yield f"{epoch.structure}, epoch {epoch.epoch}, measured {measured}"
    yield f"deviation: {deviation_of(condition)}"
    yield f"limit: {_limit_of(condition)}"
    yield f"change: {_change_of(condition)}"
    yield (
        f"data: {epoch.state}, {epoch.n_stations_used} of {epoch.n_stations} stations, "
        f"{epoch.n_points_used:,} of {epoch.n_points_in:,} points on the shaft"
    )
    if condition.lacks_a_station:
        yield f"coverage: {_coverage_of(epoch)}"
    yield f"state: {NAMES[condition.level]}"
    for reason in condition.reasons:
        yield f"  {NAMES[reason.level]}: {reason.what}"


def summary_of(condition: Condition) -> str:
    """State of an epoch in one line."""
    return f"{condition.epoch.epoch}: {condition.epoch.state}, {deviation_of(condition)}, {NAMES[condition.level]}"


def deviation_of(condition: Condition) -> str:
    """Deviation with its expanded uncertainty, or that there is none."""
    scheme, method = condition.primary
    tilt = condition.tilt
    if tilt is None:
        return f"no result of {scheme}/{method}"
    azimuth = "direction not significant" if tilt.azimuth_deg is None else f"towards {tilt.azimuth_deg:.1f}°"
    return (
        f"{1e3 * tilt.deviation_m:.1f}{_plus_minus(condition.deviation_u_m)} at {tilt.height_m:g} m, {azimuth}"
        f" ({scheme}/{method})"
    )


def facts_of(condition: Condition, now: datetime) -> dict[str, Json]:
    """State of an epoch for programs: metres, degrees, null where something does not exist."""
    epoch, tilt, change = condition.epoch, condition.tilt, condition.change
    return {
        "structure": epoch.structure,
        "epoch": epoch.epoch,
        "epoch_time": epoch.epoch_time.isoformat(),
        "age_days": round((now - epoch.epoch_time).total_seconds() / 86400.0, 3),
        "state": epoch.state,
        "reason": epoch.reason,
        "level": condition.level.name.lower(),
        "reasons": [reason.what for reason in condition.reasons],
        "primary": list(condition.primary),
        "lean_east": tilt.lean_east if tilt else None,
        "lean_north": tilt.lean_north if tilt else None,
        "azimuth_deg": tilt.azimuth_deg if tilt else None,
        "height_m": epoch.height_m,
        "deviation_m": tilt.deviation_m if tilt else None,
        "deviation_u_m": condition.deviation_u_m,
        "allowable_m": tilt.allowable_m if tilt else None,
        "verdict": tilt.verdict if tilt else None,
        "verdict_reason": tilt.verdict_reason if tilt else None,
        "reference_epoch": change.reference_epoch if change else None,
        "change_m": change.d_top_m if change else None,
        "change_u_m": condition.change_u_m,
        "change_p_value": change.p_value if change else None,
        "change_significant": change.significant if change else None,
        "n_stations": epoch.n_stations,
        "n_stations_used": epoch.n_stations_used,
        "coverage_deg": epoch.coverage_deg,
        "stations_sigma_arcsec": epoch.stations_sigma_arcsec,
        "next_station_azimuth_deg": epoch.next_station_azimuth_deg,
        "next_station_sigma_arcsec": epoch.next_station_sigma_arcsec,
    }


def _coverage_of(epoch: EpochRow) -> str:
    """How much of the shaft was seen, and where one more station would help most."""
    seen = "unknown" if epoch.coverage_deg is None else f"{epoch.coverage_deg:.0f}° of the circumference"
    azimuth_deg, now, then = (
        epoch.next_station_azimuth_deg,
        epoch.stations_sigma_arcsec,
        epoch.next_station_sigma_arcsec,
    )
    if azimuth_deg is None or now is None or then is None:
        return seen
    gain = f'would bring the sigma of the lean from {now:.1f}" to {then:.1f}"'
    return f"{seen}; one more station at azimuth {azimuth_deg:.0f}° {gain}"


def further_verdicts(condition: Condition, rows: Sequence[VerdictRow]) -> list[VerdictRow]:
    """What the limits beside the primary one say of the result that counts."""
    return [row for row in rows if (row.scheme, row.method) == condition.primary and not row.is_primary]


def _limit_of(condition: Condition) -> str:
    tilt = condition.tilt
    if tilt is None:
        return "no verdict without a result"
    limit = "none" if tilt.allowable_m is None else f"{1e3 * tilt.allowable_m:.1f} mm"
    return f"{limit}, verdict: {tilt.verdict}" + (f"; {tilt.verdict_reason}" if tilt.verdict_reason else "")


def _change_of(condition: Condition) -> str:
    change = condition.change
    if change is None:
        return "none: this is the reference epoch" if condition.epoch.is_reference else "cannot be told"
    return (
        f"since {change.reference_epoch}: {1e3 * change.d_top_m:.1f}{_plus_minus(condition.change_u_m)} at the top, "
        + (significance_text(change.significant, change.p_value, change.smallest_detectable_m))
    )


def significance_text(significant: bool | None, p_value: float | None, smallest_m: float | None) -> str:
    """Say whether a change is significant, with what probability, and what could have been found."""
    if significant is None or p_value is None:
        return "significance unknown"
    word = "significant" if significant else "not significant"
    found = "" if smallest_m is None else f"; from {1e3 * smallest_m:.1f} mm on it would be found"
    return f"{word} ({p_text(p_value)}{found})"


def _plus_minus(u_m: float | None) -> str:
    return " mm, uncertainty unknown," if u_m is None else f" ± {1e3 * u_m:.1f} mm (k=2)"


def _age(then: datetime, now: datetime) -> str:
    days = (now - then).total_seconds() / 86400.0
    if days < 0.0:
        return "in the future of this machine's clock"
    return f"{days:.0f} days ago" if days >= 2.0 else f"{24.0 * days:.0f} hours ago"
