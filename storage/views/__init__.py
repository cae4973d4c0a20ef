"""What the catalog says, as typed rows: all that command line, reports and dashboards read."""

from storage.change import ChangeRow
from storage.view_definitions import VIEWS
from storage.views.reading import (
    accuracy_rows,
    alarm_rows,
    change_rows,
    coverage_rows,
    epoch_rows,
    latest_epochs,
    pair_rows,
    removal_rows,
    rows_of,
    run_rows,
    scheme_rows,
    slice_rows,
    station_rows,
    tilt_rows,
)

__all__ = [
    "VIEWS",
    "ChangeRow",
    "accuracy_rows",
    "alarm_rows",
    "change_rows",
    "coverage_rows",
    "epoch_rows",
    "latest_epochs",
    "pair_rows",
    "removal_rows",
    "rows_of",
    "run_rows",
    "scheme_rows",
    "slice_rows",
    "station_rows",
    "tilt_rows",
]
