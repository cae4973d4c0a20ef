"""What a workspace holds of one epoch that a comparison with another one needs."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from storage.records import CoverageRow, EpochRow, SliceRow, TiltRow
from storage.views import (
    axis_covariance_rows,
    axis_parameter_rows,
    coverage_rows,
    epoch_rows,
    one_catalog,
    slice_rows_of,
    tilt_rows,
)
from storage.workspace import Workspace
from tasks.geometry.axis_parameters import AxisParameters
from tasks.parameter_rows import parameters_of

Way = tuple[str, str]
"""A scheme and a method."""


@dataclass(frozen=True, slots=True, eq=False)
class EpochRecord:
    """The axes of an epoch with their slices and parameters, by scheme and method, and what was seen of the shaft."""

    epoch: EpochRow
    tilt: Mapping[Way, TiltRow]
    parameters: Mapping[Way, AxisParameters]
    slices: Mapping[Way, Sequence[SliceRow]]
    coverage: Sequence[CoverageRow]


def load_epoch_record(workspace: Workspace, epoch: EpochRow) -> EpochRecord:
    """Read what is stored of an epoch.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    structure, name = epoch.structure, epoch.epoch
    slices: dict[Way, list[SliceRow]] = defaultdict(list)
    with one_catalog(workspace):  # to open it takes longer than to read an epoch
        for row in slice_rows_of(workspace, structure, name):
            slices[row.scheme, row.method].append(row)
        return EpochRecord(
            epoch=epoch,
            tilt={(row.scheme, row.method): row for row in tilt_rows(workspace, structure, name)},
            parameters=_parameters(workspace, structure, name),
            slices=dict(slices),
            coverage=coverage_rows(workspace, structure, name),
        )


def reference_epoch(epochs: Sequence[EpochRow]) -> EpochRow | None:
    """The epoch that changes are counted from, as the view ``changes`` chooses it; None where there is none."""
    if not epochs:
        return None
    return min(
        epochs, key=lambda row: (not row.is_reference, row.state == "failed", row.epoch_time, row.epoch)
    )


def stored_epoch(workspace: Workspace, structure: str, epoch: str) -> EpochRow | None:
    """The row of an epoch; None where it is not stored.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    return next((row for row in epoch_rows(workspace, structure) if row.epoch == epoch), None)


def _parameters(workspace: Workspace, structure: str, epoch: str) -> dict[Way, AxisParameters]:
    rows, covariances = defaultdict(list), defaultdict(list)
    for row in axis_parameter_rows(workspace, structure, epoch):
        rows[row.scheme, row.method].append(row)
    for pair in axis_covariance_rows(workspace, structure, epoch):
        covariances[pair.scheme, pair.method].append(pair)
    found = {way: parameters_of(own, covariances[way]) for way, own in rows.items()}
    return {way: one for way, one in found.items() if one is not None}
