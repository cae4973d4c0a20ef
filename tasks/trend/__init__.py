"""Trend: how the lean goes on over the epochs, when it reaches a limit, when it changed, and the control chart."""

from tasks.trend.change_dating import DatedChange, date_change
from tasks.trend.change_point import CHANGE_EPOCHS, ChangePoint, find_change
from tasks.trend.cusum import (
    ALARM_RUN_LENGTH,
    WATCH_RUN_LENGTH,
    ControlChart,
    average_run_length,
    control_chart,
    control_limit,
    recursive_residuals,
)
from tasks.trend.gls import Size, Trend, fit_trend, gls_at
from tasks.trend.limit_date import LimitDate, limit_date
from tasks.trend.onsets import EPOCHS_BESIDE, KINDS, Kind, change_column
from tasks.trend.outlook import TREND_P, Outlook, PlaneVector
from tasks.trend.series import LeanSeries
from tasks.trend.terms import DAYS_A_YEAR, Terms, choose_terms, design_columns

__all__ = [
    "ALARM_RUN_LENGTH",
    "CHANGE_EPOCHS",
    "DAYS_A_YEAR",
    "EPOCHS_BESIDE",
    "KINDS",
    "TREND_P",
    "WATCH_RUN_LENGTH",
    "ChangePoint",
    "ControlChart",
    "DatedChange",
    "Kind",
    "LeanSeries",
    "LimitDate",
    "Outlook",
    "PlaneVector",
    "Size",
    "Terms",
    "Trend",
    "average_run_length",
    "change_column",
    "choose_terms",
    "control_chart",
    "control_limit",
    "date_change",
    "design_columns",
    "find_change",
    "fit_trend",
    "gls_at",
    "limit_date",
    "recursive_residuals",
]
