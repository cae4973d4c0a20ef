"""Accuracy: the schemes against a control, as tables 1 to 3 of the paper show them."""

from tasks.accuracy.control import QUANTITIES, Control, control_of_lean, control_of_scheme
from tasks.accuracy.enough_slices import (
    Judged,
    SchemeSigma,
    best_of,
    judge_slices,
    recommended_of,
)
from tasks.accuracy.grid_text import NO_VALUE, Line, grid, number
from tasks.accuracy.over_epochs import Agreement, agreement
from tasks.accuracy.relative_error import cut_off, relative_error_pct
from tasks.accuracy.rows import accuracy_rows
from tasks.accuracy.shared_points import (
    Centres,
    common_poses_covariance,
    lean_correlation,
    shared_points_covariance,
    whole_surface_covariance,
)
from tasks.accuracy.significance import SIGNIFICANT_P, LeanDifference, lean_difference
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
    "NO_VALUE",
    "QUANTITIES",
    "RECOMMENDATIONS",
    "SIGNIFICANT_P",
    "Agreement",
    "Centres",
    "Comparison",
    "ComparisonTable",
    "Control",
    "FittingTable",
    "Judged",
    "LeanDifference",
    "Line",
    "MonitoringTable",
    "Recommendation",
    "SchemeSigma",
    "WorkloadFactor",
    "accuracy_rows",
    "agreement",
    "best_of",
    "common_poses_covariance",
    "comparison_lines",
    "comparison_table",
    "control_of_lean",
    "control_of_scheme",
    "cut_off",
    "fitting_lines",
    "fitting_table",
    "grid",
    "judge_slices",
    "lean_correlation",
    "lean_difference",
    "monitoring_lines",
    "monitoring_table",
    "number",
    "recommendation_lines",
    "recommended_of",
    "relative_error_pct",
    "savings",
    "shared_points_covariance",
    "slice_counts",
    "whole_surface_covariance",
    "workload_factors",
    "workload_lines",
]
