"""The memory of code versions that lies in a workspace."""

from contextlib import AbstractContextManager

from storage.workspace import Workspace
from tasks.code_memory import remembered_versions
from tasks.code_version import library_versions


def known_code(workspace: Workspace) -> AbstractContextManager[None]:
    """Take the versions of stages from the runs before, as long as the block lasts and no source changed."""
    return remembered_versions(workspace.runs / "code-versions.json", library_versions())
