"""Rows that follow from all epochs of a structure, for campaigns of stored_campaign."""

from dataclasses import replace

from storage.records import ChangeTestRow, ControlChartRow, TrendRow
from tests.storage.campaign import HEIGHT_M, STRUCTURE, epoch_time
from tests.storage.samples import bare_row


def trend_row(last_epoch: str, **changed: object) -> TrendRow:
    """6 ± 1 mm a year (k=2) under the primary A/paper."""
    row = replace(
        bare_row(TrendRow),
        structure=STRUCTURE,
        scheme="A",
        method="paper",
        last_epoch=last_epoch,
        last_time=epoch_time(1),
        rate_m_per_year=0.006,
        rate_sigma_m_per_year=0.0005,
        rate_significant=True,
    )
    return replace(row, **changed)


def chart_row(epoch: str, cusum: float) -> ControlChartRow:
    """A point of the control chart with limits 4 and 5."""
    return replace(
        bare_row(ControlChartRow),
        structure=STRUCTURE,
        epoch=epoch,
        scheme="A",
        method="paper",
        cusum=cusum,
        watch_limit=4.0,
        alarm_limit=5.0,
    )


RUN = "run-1"
"""Run of every epoch of stored campaigns: a test counts for epochs as they were published."""


def change_test(epoch: str, quantity: str, p_value: float) -> ChangeTestRow:
    """A change of 12 mm against e1; its statistic does not matter but for being there."""
    return replace(
        bare_row(ChangeTestRow),
        structure=STRUCTURE,
        epoch=epoch,
        reference_epoch="e1",
        scheme="A",
        method="paper",
        quantity=quantity,
        size_m=0.012 if p_value < 0.05 else 0.001,
        height_m=HEIGHT_M,
        statistic=7.8 if p_value < 0.05 else 1.0,
        freedom=2,
        p_value=p_value,
        run=RUN,
        reference_run=RUN,
    )
