"""What the catalog says, as typed rows: all that command line, reports and dashboards read."""

from storage.change import ChangeRow
from storage.surface_change import SurfaceChangeRow
from storage.view_definitions import VIEWS
from storage.views.reading import (
    accuracy_rows,
    alarm_rows,
    change_rows,
    coverage_rows,
    epoch_rows,
    latest_epochs,
    pair_rows,
    reference_lean_rows,
    removal_rows,
    rows_of,
    run_rows,
    scheme_comparison_rows,
    scheme_rows,
    slice_rows,
    station_rows,
    surface_change_rows,
    surface_map_rows,
    tilt_rows,
)

__all__ = [
    "VIEWS",
    "ChangeRow",
    "SurfaceChangeRow",
    "accuracy_rows",
    "alarm_rows",
    "change_rows",
    "coverage_rows",
    "epoch_rows",
    "latest_epochs",
    "pair_rows",
    "reference_lean_rows",
    "removal_rows",
    "rows_of",
    "run_rows",
    "scheme_comparison_rows",
    "scheme_rows",
    "slice_rows",
    "station_rows",
    "surface_change_rows",
    "surface_map_rows",
    "tilt_rows",
]
