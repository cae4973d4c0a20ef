"""``tiltwatch doctor``: whether this machine is fit."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from dataclasses import asdict

from flows.commands.options import AsJson, WorkspaceFolder
from flows.terminal import answer, say

NOT_FIT = 3


def doctor(*, workspace: WorkspaceFolder = None, as_json: AsJson = False) -> int:
    """Say whether this machine has what a run needs, and what to do where something lacks.

    Exit code 3 if anything that a run needs lacks.

    Parameters
    ----------
    workspace
        Folder whose disk is looked at; the one for temporary files where it is missing.
    """
    from flows.machine import examine_machine

    findings = examine_machine(workspace)
    code = 0 if all(finding.ok for finding in findings) else NOT_FIT
    if as_json:
        return answer(code, {"checks": [asdict(finding) for finding in findings]})
    for finding in findings:
        mark = "ok     " if finding.ok else "PROBLEM"
        say(f"{mark} {finding.name}: {finding.found}" + (f"; {finding.todo}" if finding.todo else ""))
    return code
