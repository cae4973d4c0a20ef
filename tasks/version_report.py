"""What has become of the results of a version, as lines of text: the primary epoch by epoch, the others counted."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from storage.records import TiltRow
from storage.views import VersionChangeRow, tilt_rows, version_change_rows
from storage.workspace import Workspace
from tasks.accuracy import Line, grid, number

COLUMNS: Final = ("moved", "east", "north", "old sigmas", "sigma now/then", "verdict")

NOTE: Final = (
    "moved (mm): the axis at the top now against then, in sigmas of then; the scans are the same, so this is no "
    "movement of the structure"
)


@dataclass(frozen=True, slots=True)
class VersionReport:
    """A version against the published results, over some epochs."""

    version: str
    primary: tuple[str, str]
    changes: tuple[VersionChangeRow, ...]
    new: tuple[TiltRow, ...]
    """Axes of these epochs that the version does not have."""


def version_report(
    workspace: Workspace, structure: str, version: str, epochs: Sequence[str], primary: tuple[str, str]
) -> VersionReport:
    """Compare a version with what is published now.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    wanted = set(epochs)
    changes = [row for row in version_change_rows(workspace, structure, version) if row.epoch in wanted]
    then = {(row.epoch, row.scheme, row.method) for row in changes}
    now = [row for row in tilt_rows(workspace, structure) if row.epoch in wanted]
    new = [row for row in now if (row.epoch, row.scheme, row.method) not in then]
    return VersionReport(version, (primary[0], primary[1]), tuple(changes), tuple(new))


def version_report_lines(report: VersionReport) -> list[str]:
    """The table of the primary, a line an epoch, and how many of the other axes changed."""
    label = "/".join(report.primary)
    lines = [_line(row) for row in report.changes if (row.scheme, row.method) == report.primary]
    lines += [
        Line(row.epoch, ("new", *([""] * 4), row.verdict))
        for row in report.new
        if (row.scheme, row.method) == report.primary
    ]
    title = f"{label} now against version {report.version}"
    table = [*grid(title, COLUMNS, lines), NOTE] if lines else [f"{title}: no axis in either"]
    return [*table, *_others(report)]


def _line(row: VersionChangeRow) -> Line:
    if row.outcome == "unchanged":
        return Line(row.epoch, ("unchanged", *([""] * 4), _verdict(row)))
    if row.outcome == "gone":
        return Line(row.epoch, ("no axis now", *([""] * 4), _verdict(row)))
    d_east, d_north = row.d_lean_east, row.d_lean_north
    return Line(
        row.epoch,
        (
            number(row.d_top_m, 3, 1e3),
            number(None if d_east is None else row.height_m * d_east, 3, 1e3),
            number(None if d_north is None else row.height_m * d_north, 3, 1e3),
            number(row.d_sigmas, 2),
            number(row.sigma_ratio, 3),
            _verdict(row),
        ),
    )


def _verdict(row: VersionChangeRow) -> str:
    if row.verdict_now is None or not row.verdict_changed:
        return row.verdict_before
    return f"{row.verdict_before} -> {row.verdict_now}"


def _others(report: VersionReport) -> Iterator[str]:
    others = [row for row in report.changes if (row.scheme, row.method) != report.primary]
    new = [row for row in report.new if (row.scheme, row.method) != report.primary]
    if not others and not new:
        return
    counts = Counter(row.outcome for row in others)
    told = ", ".join(f"{counts[outcome]} {outcome}" for outcome in ("changed", "unchanged", "gone"))
    yield f"other schemes and methods: {told}, {len(new)} new"
    largest = max((row for row in others if row.d_top_m is not None), key=_movement, default=None)
    if largest is not None and largest.outcome == "changed":
        name = f"{largest.scheme}/{largest.method} of {largest.epoch}"
        yield f"most of them: {number(largest.d_top_m, 3, 1e3)} mm, {name}"


def _movement(row: VersionChangeRow) -> float:
    return -1.0 if row.d_top_m is None else row.d_top_m
