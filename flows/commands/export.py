"""``tiltwatch export``: a table of the workspace, or geometry of an epoch, as a file."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, BinaryIO

from cyclopts import Parameter

from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder, load_with_workspace, workspace_of
from flows.terminal import Json, answer, complain, note
from storage.errors import UsageError

if TYPE_CHECKING:
    from storage.drawing import DrawingChoice, Exported
    from storage.workspace import Workspace
    from tasks.settings import Campaign

BINARY = ("parquet", "las", "laz")
ARCHIVE = "archive"

Write = Callable[["Path | BinaryIO"], "Exported | None"]


def export(  # noqa: PLR0913 (options of a command)
    file: CampaignFile,
    what: Annotated[str, Parameter(name="WHAT")],
    /,
    *,
    file_format: Annotated[str | None, Parameter(name="--format")] = None,
    epoch: str | None = None,
    scheme: str | None = None,
    method: str | None = None,
    scans: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    cache: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    out: Path | None = None,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Write a view of the catalog, the geometry of an epoch, or the whole record to a file; to stdout where none is named.

    Geometry lies where the campaign states its positions: x east, y north, z up in metres, origin_m added again. The file
    says so itself.

    Parameters
    ----------
    what
        Geometry: axis (axis, plumb line, foot, top and lean vector, each with its sigmas), slice-circles or cloud (the
        points of the isolated shaft). A view: epochs, stations, pairs, coverage, surface_map, surface_changes, slices,
        tilt, verdicts, accuracy, changes, reference_leans, scheme_comparison, alarms, runs, schemes, removals or latest.
        archive: campaign file and workspace as one tar, for a backup or another machine; restore brings it back.
    file_format
        A view: csv, json or parquet. axis and slice-circles: csv, dxf, geojson or parquet. cloud: csv, las, laz or parquet.
        archive: tar, which need not be said.
    epoch
        Epoch of the geometry; the newest that has it where none is named.
    scheme
        Scheme of the geometry; scheme and method of the primary where neither is named.
    method
        Method of the geometry.
    scans
        Put the scans into the archive, too: gigabytes, but with them everything can be computed again elsewhere.
    cache
        Put what the stages made into the archive, too: then nothing is computed again elsewhere.
    out
        File to write; one that is there is replaced.
    """
    from storage.upgrade import ready_workspace

    if out is None and as_json:
        raise UsageError("--json answers on stdout, where the table would go; name a file with --out")
    if out is None and (file_format in BINARY or what == ARCHIVE) and sys.stdout.isatty():
        raise UsageError(f"{file_format or what} cannot be read on a terminal; name a file with --out")
    campaign = load_with_workspace(file, workspace)
    place = ready_workspace(workspace_of(campaign.folder, workspace))
    if what == ARCHIVE:
        from flows.archiving import ArchiveWords, check_archive_words, export_archive

        check_archive_words(file_format, epoch or scheme or method)
        return export_archive(
            place, campaign, ArchiveWords(file, scans=scans, cache=cache, out=out, as_json=as_json)
        )
    if scans or cache:
        raise UsageError("--scans and --cache are for an archive: tiltwatch export FILE archive")
    if file_format is None:
        raise UsageError(f"{what} needs a --format; `tiltwatch export --help` shows which there are")
    write = _writer(place, what, file_format, _choice(place, campaign, epoch, scheme, method))
    if out is None:
        sys.stdout.flush()
        _warn(write(sys.stdout.buffer))
        sys.stdout.buffer.flush()
        return 0
    target = out.expanduser().absolute()
    written = write(target)
    _warn(written)
    if as_json:
        return answer(0, {"out": str(target), "what": what, "format": file_format, **_facts(written)})
    note(f"wrote {target}", *_told(what, written))
    return 0


def _choice(
    place: "Workspace", campaign: "Campaign", epoch: str | None, scheme: str | None, method: str | None
) -> "DrawingChoice":
    from flows.epoch_frame import frame_of_epoch
    from storage.drawing import DrawingChoice

    return DrawingChoice(
        structure=campaign.structure.id,
        primary=(campaign.report.primary[0], campaign.report.primary[1]),
        frame_of=lambda row: frame_of_epoch(place, campaign, row),
        epoch=epoch,
        scheme=scheme,
        method=method,
    )


def _writer(place: "Workspace", what: str, file_format: str, choice: "DrawingChoice") -> Write:
    """What writes the view or the geometry.

    Raises
    ------
    UsageError
        If it is neither, or a view is asked for with words that choose geometry.
    """
    from storage.drawing import GEOMETRY, export_geometry
    from storage.export import export_view
    from storage.view_definitions import VIEWS

    if what in GEOMETRY:
        return lambda out: export_geometry(place, what, file_format, choice, out)
    if what not in VIEWS:
        raise UsageError(
            f"unknown view {what!r}; known: {', '.join(VIEWS)}; geometry: {', '.join(GEOMETRY)}; archive"
        )
    if choice.names_an_axis or choice.epoch is not None:
        raise UsageError(
            f"--epoch, --scheme and --method choose geometry ({', '.join(GEOMETRY)}); a view is written whole"
        )
    return lambda out: export_view(place, what, file_format, out)


def _warn(written: "Exported | None") -> None:
    if written is not None and written.warnings:
        complain(*(f"warning: {warning}" for warning in written.warnings))


def _facts(written: "Exported | None") -> dict[str, Json]:
    if written is None:
        return {}
    return {
        "epoch": written.epoch,
        "count": written.count,
        "coordinates": written.coordinates,
        "warnings": written.warnings,
    }


def _told(what: str, written: "Exported | None") -> list[str]:
    if written is None:
        return []
    counted = "points" if what == "cloud" else "shapes"
    return [f"{what} of epoch {written.epoch}: {written.count:,} {counted}; {written.coordinates}"]
