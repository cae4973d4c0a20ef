"""Rows of the tables ``trends`` and ``control_chart`` of a structure, made from its stored axes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.records import ControlChartRow, TiltRow, TrendRow
from tasks.geometry.failure import FitFailure
from tasks.lean_series import YEAR, StoredSeries, stored_series
from tasks.trend import (
    ALARM_RUN_LENGTH,
    CHANGE_EPOCHS,
    EPOCHS_BESIDE,
    TREND_P,
    WATCH_RUN_LENGTH,
    ChangePoint,
    LimitDate,
    Trend,
    change_column,
    control_chart,
    control_limit,
    find_change,
    fit_trend,
    limit_date,
)

SEED: Final = 20250314
"""Of the simulated series behind the p value of a change point; the same rows give the same p value."""

NONE: Final = "none"
WATCH: Final = "watch"
ALARM: Final = "alarm"


def trend_rows(
    tilt: Sequence[TiltRow],
    temperatures: Mapping[str, float] | None = None,
    primary: tuple[str, str] | None = None,
) -> list[TrendRow]:
    """Trend of every scheme and method of a structure over all its epochs.

    The allowable deviation that is extrapolated to is that of the last epoch. Where a change point is significant, rate and
    date are those after it; ``model`` then begins with the change.

    Parameters
    ----------
    tilt : sequence of TiltRow
        The axes of all epochs of one structure, in any order; those without a covariance are left out.
    temperatures : mapping of epoch to degrees Celsius, or None
        Where every epoch has one, the movement with temperature is estimated.
    primary : (scheme, method) or None
        Look for a change point under this one only and let the others follow it: all see the same structure, and to look
        under each would ask chance once for every one. None looks under each.

    Returns
    -------
    list of TrendRow
        In the order in which schemes and methods first appear.
    """
    every = stored_series(tilt, temperatures or {})
    found = {one.label: _change_of(one) for one in every if primary is None or one.label == primary}
    leading = None if primary is None else found.get(primary)
    return [_trend_row(one, found.get(one.label), leading) for one in every]


def chart_rows(tilt: Sequence[TiltRow]) -> list[ControlChartRow]:
    """Control chart of every scheme and method of a structure, from its second epoch on.

    Parameters
    ----------
    tilt : sequence of TiltRow
        The axes of all epochs of one structure, in any order; those without a covariance are left out.
    """
    return [row for one in stored_series(tilt, {}) for row in _charted(one)]


@dataclass(frozen=True, slots=True)
class _Change:
    """What a search for a change point came to: the ``point`` where one is significant, its p value and the words."""

    point: ChangePoint | None
    p_value: float | None
    said: str


def _change_of(stored: StoredSeries) -> _Change:
    found = find_change(stored.series, np.random.default_rng(SEED))
    if isinstance(found, FitFailure):
        return _Change(None, None, found.reason)
    if found.p_value >= TREND_P:
        return _Change(None, found.p_value, f"no change point: the best has p = {found.p_value:.2g}")
    what = "step" if found.kind == "step" else "turn of the rate"
    when = stored.time_of(found.dated.time)
    return _Change(found, found.p_value, f"{what} in {when:%Y-%m}, p = {found.p_value:.2g}")


def _trend_row(stored: StoredSeries, own: _Change | None, leading: _Change | None) -> TrendRow:
    """``own`` is None where the series was not searched; it then follows ``leading``."""
    change = leading if own is None else own
    point = None if change is None else change.point
    column = None if point is None else _column_of(stored, point)
    fitted = fit_trend(stored.series, extra=column)
    if isinstance(fitted, FitFailure):
        return _headed(stored, "level", [fitted.reason])
    if own is not None and own.point is not None:
        fitted = replace(fitted, outlook=own.point.dated.outlook)
    reached, said = _limit(stored, fitted)
    known = [
        fitted.terms.reason,
        "" if own is None else own.said,
        _follows(own, leading, column is not None),
        said,
    ]
    row = _headed(stored, _model(fitted, point if column is not None else None), known)
    row = _with_limit(_with_sizes(_with_rate(row, fitted), fitted), reached)
    return row if own is None else _with_change(row, stored, own)


def _column_of(stored: StoredSeries, point: ChangePoint) -> NDArray[np.float64] | None:
    """Column of a change for a series; None where the series has not two epochs on either side."""
    times = np.unique(stored.series.times)
    before = int(np.count_nonzero(times < point.dated.time))
    if min(before, len(times) - before) < EPOCHS_BESIDE or len(times) < CHANGE_EPOCHS:
        return None
    return change_column(stored.series, point.kind, point.dated.time)


def _follows(own: _Change | None, leading: _Change | None, followed: bool) -> str:
    if own is not None or leading is None or leading.point is None:
        return ""
    return "change as found under the primary scheme" if followed else "too few epochs beside the change"


def _model(fitted: Trend, point: ChangePoint | None) -> str:
    if point is None:
        return fitted.terms.model
    return f"{'step' if point.kind == 'step' else 'turn of the rate'} + {fitted.terms.model}"


def _headed(stored: StoredSeries, model: str, known: list[str]) -> TrendRow:
    first, last = stored.rows[0], stored.rows[-1]
    left_out = "" if stored.left_out == 0 else f"{stored.left_out} epochs without a covariance left out"
    return TrendRow(
        structure=last.structure,
        scheme=last.scheme,
        method=last.method,
        n_epochs=len(stored.rows),
        first_epoch=first.epoch,
        last_epoch=last.epoch,
        first_time=first.epoch_time,
        last_time=last.epoch_time,
        height_m=last.height_m,
        model=model,
        reason="; ".join(said for said in [*known, left_out] if said),
        limit_m=last.allowable_m,
    )


def _with_rate(row: TrendRow, fitted: Trend) -> TrendRow:
    rate = fitted.rate
    return replace(
        row,
        rate_east_m_per_year=float(rate.value[0]),
        rate_north_m_per_year=float(rate.value[1]),
        rate_cov_ee=float(rate.covariance[0, 0]),
        rate_cov_en=float(rate.covariance[0, 1]),
        rate_cov_nn=float(rate.covariance[1, 1]),
        rate_m_per_year=rate.size,
        rate_sigma_m_per_year=rate.sigma,
        rate_p_value=fitted.rate_p_value,
        rate_significant=fitted.rate_p_value < TREND_P,
    )


def _with_sizes(row: TrendRow, fitted: Trend) -> TrendRow:
    season, temperature = fitted.season, fitted.temperature
    return replace(
        row,
        random_walk_m_per_sqrt_year=fitted.random_walk,
        season_m=None if season is None else season.value,
        season_sigma_m=None if season is None else season.sigma,
        temperature_m_per_degree=None if temperature is None else temperature.value,
        temperature_sigma_m_per_degree=None if temperature is None else temperature.sigma,
        misfit_p_value=fitted.misfit_p,
    )


def _limit(stored: StoredSeries, fitted: Trend) -> tuple[LimitDate | None, str]:
    limit_m = stored.rows[-1].allowable_m
    if limit_m is None:
        return None, "no limit at this height"
    reached = limit_date(fitted.outlook, limit_m)
    return reached, f"limit of {1000 * limit_m:.1f} mm: {reached.reason}"


def _with_limit(row: TrendRow, reached: LimitDate | None) -> TrendRow:
    if reached is None:
        return row

    def instant(years: float | None) -> datetime | None:
        return None if years is None else row.last_time + years * YEAR

    return replace(
        row,
        limit_reached_at=instant(reached.expected),
        limit_earliest_at=instant(reached.earliest),
        limit_latest_at=instant(reached.latest),
    )


def _with_change(row: TrendRow, stored: StoredSeries, change: _Change) -> TrendRow:
    if change.point is None:
        return replace(row, change_point_p_value=change.p_value)
    point, dated = change.point, change.point.dated
    step = dated.change if point.kind == "step" else None
    return replace(
        row,
        change_point_epoch=stored.rows[point.first_epoch].epoch,
        change_point_time=stored.time_of(dated.time),
        change_point_earliest=stored.time_of(dated.earliest),
        change_point_latest=stored.time_of(dated.latest),
        change_point_kind=point.kind,
        change_point_p_value=change.p_value,
        rate_before_m_per_year=dated.rate_before.size,
        rate_after_m_per_year=dated.rate_after.size,
        rate_after_sigma_m_per_year=dated.rate_after.sigma,
        step_m=None if step is None else step.size,
        step_sigma_m=None if step is None else step.sigma,
    )


def _charted(stored: StoredSeries) -> list[ControlChartRow]:
    chart = control_chart(stored.series)
    watch, alarm = control_limit(WATCH_RUN_LENGTH), control_limit(ALARM_RUN_LENGTH)
    return [
        ControlChartRow(
            structure=row.structure,
            epoch=row.epoch,
            epoch_time=row.epoch_time,
            scheme=row.scheme,
            method=row.method,
            standardised_1=float(chart.standardised[i, 0]),
            standardised_2=float(chart.standardised[i, 1]),
            cusum_up_1=float(chart.up[i, 0]),
            cusum_down_1=float(chart.down[i, 0]),
            cusum_up_2=float(chart.up[i, 1]),
            cusum_down_2=float(chart.down[i, 1]),
            cusum=float(largest),
            watch_limit=watch,
            alarm_limit=alarm,
            signal=ALARM if largest >= alarm else WATCH if largest >= watch else NONE,
        )
        for i, (row, largest) in enumerate(zip(stored.rows[1:], chart.largest, strict=True))
    ]
