"""Where a workspace keeps what was taken in from an inbox: one file an epoch, and what came of it."""

import json
from collections.abc import Mapping
from pathlib import Path

from storage.atomic import make_folder, write_atomically
from storage.errors import StorageError
from storage.ids import check_id
from storage.locks import publish_lock
from storage.second_copies import keep_second
from storage.workspace import Workspace

SUFFIX = ".toml"


def intake_files(ws: Workspace, structure: str) -> tuple[Path, ...]:
    """Files of the epochs of a structure that were taken in, sorted by name; none where the workspace is not there."""
    folder = ws.intake / check_id(structure, "a structure")
    return tuple(sorted(folder.glob(f"*{SUFFIX}")))


def intake_file(ws: Workspace, structure: str, epoch: str) -> Path:
    """File of an epoch that was taken in.

    Raises
    ------
    InputError
        If an id cannot be a file name.
    """
    folder = ws.intake / check_id(structure, "a structure")
    return folder / f"{check_id(epoch, 'an epoch')}{SUFFIX}"


def write_intake(ws: Workspace, structure: str, epoch: str, text: str) -> Path:
    """Replace the file of an epoch that was taken in.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    path = intake_file(ws, structure, epoch)
    with publish_lock(ws):  # else the first would seem to be changed by hand until the second is there
        write_atomically(path, text.encode())
        keep_second(ws, path)
    return path


def write_run_note(ws: Workspace, structure: str, epoch: str, note: Mapping[str, object]) -> None:
    """Note how the run of an epoch that was taken in ended."""
    path = intake_file(ws, structure, epoch).with_suffix(".run.json")
    write_atomically(path, json.dumps(note, indent=1).encode() + b"\n")


def read_run_note(ws: Workspace, structure: str, epoch: str) -> Mapping[str, object] | None:
    """How the last run of an epoch that was taken in ended; None if none did, or the note is damaged."""
    path = intake_file(ws, structure, epoch).with_suffix(".run.json")
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None
    return content if isinstance(content, dict) else None


def write_preview(ws: Workspace, structure: str, epoch: str, content: Mapping[str, object]) -> Path:
    """Replace the preview of an epoch.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    path = ws.previews / check_id(structure, "a structure") / f"{check_id(epoch, 'an epoch')}.json"
    write_atomically(path, json.dumps(content, indent=1, allow_nan=False).encode() + b"\n")
    return path


def append_watch_log(ws: Workspace, structure: str, line: str) -> None:
    """Append a line to the log of the watch of a structure.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    path = ws.root / "logs" / f"watch-{check_id(structure, 'a structure')}.jsonl"
    make_folder(path.parent)
    try:
        with path.open("a", encoding="utf-8") as file:
            file.write(f"{line}\n")
    except OSError as fault:
        raise StorageError(f"cannot write {path}: {fault.strerror}; make room or access") from fault
