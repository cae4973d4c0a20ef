"""The comparison of schemes as a workspace holds it, of one epoch or over all."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from storage.records import SchemeComparisonRow
from storage.views import (
    reference_lean_rows,
    scheme_comparison_rows,
    slice_rows,
    tilt_rows,
)
from storage.workspace import Workspace
from tasks.accuracy import Agreement, LeanDifference, agreement, lean_difference
from tasks.scheme_comparison import EpochAxes, compare_schemes, labels_of


@dataclass(frozen=True, slots=True)
class SchemeAgreement:
    """A scheme and method, or a source, against another over the epochs that have both."""

    compared: str
    against: str
    height_m: float
    agreement: Agreement


def epoch_axes(workspace: Workspace, structure: str, epoch: str) -> EpochAxes:
    """Read all axes of an epoch, with their slices and the reference measurements.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    tilt = tilt_rows(workspace, structure, epoch)
    slices = [one for row in tilt for one in slice_rows(workspace, structure, epoch, row.scheme, row.method)]
    return EpochAxes(structure, epoch, tilt, slices, reference_lean_rows(workspace, structure, epoch))


def pairs_of(axes: EpochAxes) -> list[SchemeComparisonRow]:
    """Compare every two axes of an epoch: the later one against the earlier one, in the order of the schemes."""
    labels = labels_of(axes)
    return [
        row
        for number, label in enumerate(labels)
        for row in compare_schemes(axes, label)
        if row.compared in labels[number + 1 :]
    ]


def agreements(workspace: Workspace, structure: str, against: str) -> list[SchemeAgreement]:
    """Say of every axis that at least two stored epochs compare with ``against`` whether they agree over the epochs.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    rows = [row for row in scheme_comparison_rows(workspace, structure) if row.against == against]
    return [
        found for label in dict.fromkeys(row.compared for row in rows) if (found := _agreement(rows, label))
    ]


def _agreement(rows: Sequence[SchemeComparisonRow], label: str) -> SchemeAgreement | None:
    mine = [row for row in rows if row.compared == label]
    differences = [found for row in mine if (found := _difference(row)) is not None]
    if len(differences) < 2:
        return None
    return SchemeAgreement(label, mine[0].against, mine[0].height_m, agreement(differences))


def _difference(row: SchemeComparisonRow) -> LeanDifference | None:
    if row.d_lean_east is None or row.d_lean_north is None:
        return None
    d = np.array([row.d_lean_east, row.d_lean_north])
    if row.d_cov_ee is None or row.d_cov_en is None or row.d_cov_nn is None:
        return lean_difference(d, None)
    return lean_difference(d, np.array([[row.d_cov_ee, row.d_cov_en], [row.d_cov_en, row.d_cov_nn]]))


def newest_epoch(workspace: Workspace, structure: str) -> str | None:
    """Id of the newest epoch that has an axis; None where none has.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    rows = tilt_rows(workspace, structure)
    return rows[-1].epoch if rows else None
