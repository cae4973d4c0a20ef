"""What follows from all epochs of a structure: changes against the reference epoch, trends, control charts."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from storage.records import ChangeTestRow, EpochRow, TiltRow
from storage.views import change_test_rows, epoch_rows, tilt_rows
from storage.workspace import Workspace
from tasks.change_rows import change_test_rows_of
from tasks.code_version import code_version
from tasks.epoch_record import EpochRecord, Way, load_epoch_record, reference_epoch
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
        "change_tests": _changes(workspace, structure, tilt),
        "trends": trend_rows(tilt, temperatures, campaign.report.primary),
        "control_chart": chart_rows(tilt),
    }


@dataclass(frozen=True, slots=True)
class _Known:
    """The comparisons that are stored already and hold for the epochs as they are, by the code as it is now."""

    rows: Mapping[tuple[str, str], Sequence[ChangeTestRow]]
    code: str

    def of(self, epoch: EpochRow, reference: EpochRow) -> Sequence[ChangeTestRow]:
        """Those of an epoch with the reference epoch."""
        return self.rows.get((epoch.epoch, reference.epoch), ())


def _known(workspace: Workspace, structure: str) -> _Known:
    code, rows = code_version(change_test_rows_of), defaultdict(list)
    for row in change_test_rows(workspace, structure):
        if row.code_version == code:
            rows[row.epoch, row.reference_epoch].append(row)
    return _Known(rows, code)


def _changes(workspace: Workspace, structure: str, tilt: Sequence[TiltRow]) -> list[ChangeTestRow]:
    epochs = epoch_rows(workspace, structure)
    reference = reference_epoch(epochs)
    if reference is None:
        return []
    ways: dict[str, set[Way]] = defaultdict(set)
    for row in tilt:
        ways[row.epoch].add((row.scheme, row.method))
    known = _known(workspace, structure)
    base: EpochRecord | None = None
    made: list[ChangeTestRow] = []
    for epoch in epochs:
        if epoch.epoch == reference.epoch or not ways[epoch.epoch] & ways[reference.epoch]:
            continue
        rows = known.of(epoch, reference)
        if not rows:
            base = base or load_epoch_record(workspace, reference)
            rows = change_test_rows_of(base, load_epoch_record(workspace, epoch), known.code, reference.epoch)
        made += rows
    # the order in which they are read back: the same rows are the same file
    return sorted(made, key=lambda row: (row.epoch_time, row.epoch, row.scheme, row.method, row.quantity))
