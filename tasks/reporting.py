"""What is stored of an epoch, as lines of text: Tables 1 to 3 of the paper, per method."""

from collections.abc import Iterator, Sequence
from typing import Final

from storage.records import AccuracyRow, SchemeRow, TiltRow
from storage.views import accuracy_rows, scheme_rows, tilt_rows
from storage.workspace import Workspace
from tasks.accuracy import (
    Control,
    comparison_lines,
    comparison_table,
    fitting_lines,
    fitting_table,
    monitoring_lines,
    monitoring_table,
    recommendation_lines,
    slice_counts,
    workload_lines,
)

METHODS_FIRST: Final = ("paper", "robust", "surface")
"""Order of the methods in print."""


def epoch_tables_text(workspace: Workspace, structure: str, epoch: str) -> list[str]:
    """Tables 1 to 3 of the paper for every method of an epoch, the workload and the recommendation.

    Schemes that gave no axis are named with the reason. An epoch without any axis gives these lines alone.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    rows = tilt_rows(workspace, structure, epoch)
    control = _control(accuracy_rows(workspace, structure, epoch))
    lines: list[str] = []
    for method in sorted({row.method for row in rows}, key=_place):
        lines += _method_tables([row for row in rows if row.method == method], control)
    lines += _failed(scheme_rows(workspace, structure, epoch))
    if rows:
        counts = slice_counts([row for row in rows if row.method == rows[0].method])
        lines += ["", *workload_lines(counts), "", *recommendation_lines(counts)]
    return lines


def _method_tables(rows: Sequence[TiltRow], control: Control | None) -> Iterator[str]:
    yield from ("", *fitting_lines(fitting_table(rows)))
    yield from ("", *monitoring_lines(monitoring_table(rows)))
    compared = [row for row in rows if control is not None and f"{row.scheme}/{row.method}" != control.label]
    if control is None:
        yield from ("", "Table 3 is left out: the control has no axis in this epoch")
    elif compared:
        yield from ("", *comparison_lines(comparison_table(compared, control)))


def _control(rows: Sequence[AccuracyRow]) -> Control | None:
    """Put the control together from the rows that were counted from it."""
    if not rows:
        return None
    reference = {row.quantity: row.reference for row in rows if row.control == rows[0].control}
    return Control(
        label=rows[0].control,
        beta_deg=reference["beta_deg"],
        azimuth_deg=reference.get("azimuth_deg"),
        tilt_deg=reference["tilt_deg"],
        verticality_permille=reference["verticality_permille"],
        deviation_m=reference["deviation_m"],
    )


def _failed(rows: Sequence[SchemeRow]) -> Iterator[str]:
    failed = [row for row in rows if row.state != "ok"]
    if failed:
        yield ""
    for row in failed:
        yield f"{row.scheme}/{row.method} gave no axis: {row.reason or 'no reason stored'}"


def _place(method: str) -> int:
    return METHODS_FIRST.index(method) if method in METHODS_FIRST else len(METHODS_FIRST)
