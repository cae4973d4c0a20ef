"""What follows from all epochs of a structure: changes against the reference epoch, trends, control charts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from storage.records import ChangeTestRow, EpochRow
from storage.views import change_test_rows, epoch_rows, tilt_rows
from storage.workspace import Workspace
from tasks.change_rows import change_test_rows_of
from tasks.code_version import code_version
from tasks.epoch_record import load_epoch_record, reference_epoch
from tasks.settings import Campaign
from tasks.trend_rows import chart_rows, trend_rows


def assess(workspace: Workspace, campaign: Campaign) -> Mapping[str, Sequence[object]]:
    """Make the tables that follow from all epochs of a structure; epochs that did not change are not compared again.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    structure = campaign.structure.id
    tilt = tilt_rows(workspace, structure)
    temperatures = {
        epoch.id: epoch.temperature_c for epoch in campaign.epochs if epoch.temperature_c is not None
    }
    return {
        "change_tests": _changes(workspace, structure),
        "trends": trend_rows(tilt, temperatures, campaign.report.primary),
        "control_chart": chart_rows(tilt),
    }


@dataclass(frozen=True, slots=True)
class _Known:
    """The comparisons that are stored already."""

    rows: Sequence[ChangeTestRow]
    code: str

    def of(self, epoch: EpochRow, reference: EpochRow) -> list[ChangeTestRow]:
        """Those of an epoch as it is now with the reference epoch as it is now, by the code as it is now."""
        return [
            row
            for row in self.rows
            if (row.epoch, row.run, row.code_version) == (epoch.epoch, epoch.run, self.code)
            and (row.reference_epoch, row.reference_run) == (reference.epoch, reference.run)
        ]


def _changes(workspace: Workspace, structure: str) -> list[ChangeTestRow]:
    epochs = epoch_rows(workspace, structure)
    reference = reference_epoch(epochs)
    if reference is None:
        return []
    known = _Known(change_test_rows(workspace, structure), code_version(change_test_rows_of))
    base = None
    made: list[ChangeTestRow] = []
    for epoch in epochs:
        if epoch.epoch == reference.epoch:
            continue
        rows = known.of(epoch, reference)
        if not rows:
            base = base or load_epoch_record(workspace, reference)
            record = load_epoch_record(workspace, epoch)
            rows = change_test_rows_of(base, record, known.code, before_is_reference=True)
        made += rows
    # the order in which they are read back: the same rows are the same file
    return sorted(made, key=lambda row: (row.epoch_time, row.epoch, row.scheme, row.method, row.quantity))
