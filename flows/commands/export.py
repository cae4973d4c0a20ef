"""``tiltwatch export``: a table of the workspace as a file."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder, load_with_workspace, workspace_of
from flows.terminal import answer, note
from storage.errors import UsageError

BINARY = ("parquet",)


def export(
    file: CampaignFile,
    what: Annotated[str, Parameter(name="WHAT")],
    /,
    *,
    file_format: Annotated[str, Parameter(name="--format")],
    out: Path | None = None,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Write a view of the catalog to a file, or to stdout where none is named.

    Parameters
    ----------
    what
        epochs, stations, pairs, coverage, surface_map, surface_changes, slices, tilt, verdicts, accuracy, changes,
        reference_leans, scheme_comparison, alarms, runs, schemes, removals or latest.
    file_format
        csv, json or parquet.
    out
        File to write; one that is there is replaced.
    """
    from storage.export import export_view
    from storage.workspace import existing_workspace

    if out is None and as_json:
        raise UsageError("--json answers on stdout, where the table would go; name a file with --out")
    if out is None and file_format in BINARY and sys.stdout.isatty():
        raise UsageError(f"{file_format} cannot be read on a terminal; name a file with --out")
    campaign = load_with_workspace(file, workspace)
    place = existing_workspace(workspace_of(campaign.folder, workspace))
    if out is None:
        sys.stdout.flush()
        export_view(place, what, file_format, sys.stdout.buffer)
        sys.stdout.buffer.flush()
        return 0
    target = out.expanduser().absolute()
    export_view(place, what, file_format, target)
    if as_json:
        return answer(0, {"out": str(target), "what": what, "format": file_format})
    note(f"wrote {target}")
    return 0
