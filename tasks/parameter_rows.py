"""Axis and radius of an epoch with their joint covariance, as rows and back."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from storage.records import AxisCovarianceRow, AxisParameterRow
from tasks.epoch_tables import Home, SchemeOutcome
from tasks.geometry.axis_parameters import AxisParameters


@dataclass(frozen=True, slots=True)
class ParameterRows:
    """The parameters of an axis, and the upper triangle of their covariance."""

    parameters: tuple[AxisParameterRow, ...]
    covariances: tuple[AxisCovarianceRow, ...]


def rows_of_outcomes(home: Home, outcomes: Sequence[SchemeOutcome]) -> ParameterRows:
    """Rows of every scheme and method of an epoch whose axis has parameters."""
    told = [
        _rows(home, outcome.scheme.name, outcome.method.name, outcome.lean.parameters)
        for outcome in outcomes
        if outcome.lean is not None and outcome.lean.parameters is not None
    ]
    return ParameterRows(
        tuple(row for one in told for row in one.parameters),
        tuple(row for one in told for row in one.covariances),
    )


def parameters_of(
    parameters: Sequence[AxisParameterRow], covariances: Sequence[AxisCovarianceRow]
) -> AxisParameters | None:
    """Build the parameters of one axis from its rows; None where it has none."""
    ordered = sorted(parameters, key=lambda row: row.place)
    if not ordered:
        return None
    n = len(ordered)
    matrices = np.zeros((3, n, n))
    for row in covariances:
        for i, j in ((row.place_1, row.place_2), (row.place_2, row.place_1)):
            matrices[:, i, j] = row.covariance, row.form_covariance, row.frame_covariance
    return AxisParameters(
        tuple(row.parameter for row in ordered), np.array([row.value for row in ordered]), *matrices
    )


def _rows(home: Home, scheme: str, method: str, found: AxisParameters) -> ParameterRows:
    axis = (home.structure, home.epoch, scheme, method)
    sigmas = np.sqrt(np.diag(found.covariance))
    n = len(found.names)
    return ParameterRows(
        tuple(
            AxisParameterRow(*axis, name, place, float(found.values[place]), float(sigmas[place]))
            for place, name in enumerate(found.names)
        ),
        tuple(
            AxisCovarianceRow(
                *axis,
                i,
                j,
                float(found.covariance[i, j]),
                float(found.form_covariance[i, j]),
                float(found.frame_covariance[i, j]),
            )
            for i in range(n)
            for j in range(i, n)
        ),
    )
