"""Accuracy: the schemes against a control, as tables 1 to 3 of the paper show them."""

from tasks.accuracy.control import QUANTITIES, Control, control_of_lean, control_of_scheme
from tasks.accuracy.relative_error import cut_off, relative_error_pct
from tasks.accuracy.rows import accuracy_rows
from tasks.accuracy.tables import (
    Comparison,
    ComparisonTable,
    FittingTable,
    MonitoringTable,
    comparison_table,
    fitting_table,
    monitoring_table,
)
from tasks.accuracy.tables_text import (
    comparison_lines,
    fitting_lines,
    monitoring_lines,
    recommendation_lines,
    workload_lines,
)
from tasks.accuracy.workload import (
    RECOMMENDATIONS,
    Recommendation,
    WorkloadFactor,
    savings,
    slice_counts,
    workload_factors,
)

__all__ = [
    "QUANTITIES",
    "RECOMMENDATIONS",
    "Comparison",
    "ComparisonTable",
    "Control",
    "FittingTable",
    "MonitoringTable",
    "Recommendation",
    "WorkloadFactor",
    "accuracy_rows",
    "comparison_lines",
    "comparison_table",
    "control_of_lean",
    "control_of_scheme",
    "cut_off",
    "fitting_lines",
    "fitting_table",
    "monitoring_lines",
    "monitoring_table",
    "recommendation_lines",
    "relative_error_pct",
    "savings",
    "slice_counts",
    "workload_factors",
    "workload_lines",
]
