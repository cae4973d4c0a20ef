"""``tiltwatch verify``: whether everything is stored whole and true to its digest."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from dataclasses import asdict
from typing import Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder, load_with_workspace, workspace_of
from flows.terminal import answer, complain, note, say

NOT_WHOLE = 3


def verify(
    file: CampaignFile,
    /,
    *,
    deep: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Check that everything in the workspace is whole and true to its digest.

    Exit code 3 if anything is not.

    Parameters
    ----------
    deep
        Hash every artifact again, also those that did not change since they were last hashed.
    """
    from storage.places import with_store
    from storage.verify import verify_workspace, verify_workspace_deeply
    from storage.workspace import existing_workspace

    campaign = load_with_workspace(file, workspace)
    folder = existing_workspace(workspace_of(campaign.folder, workspace))
    place = with_store(folder, campaign.execution.store)
    report = verify_workspace_deeply(place) if deep else verify_workspace(place)
    code = NOT_WHOLE if report.faults else 0
    complain(*(f"error: {fault.where}: {fault.what}; {fault.what_to_do}" for fault in report.faults))
    note(*(f"note: {told.where}: {told.what}; {told.what_to_do}" for told in report.notes))
    if as_json:
        found = {name: [asdict(told) for told in getattr(report, name)] for name in ("faults", "notes")}
        return answer(code, {"workspace": str(place.root), "checked": report.checked, **found})
    say(f"{place.root}: {report.checked} checked, {len(report.faults)} faults")
    return code
