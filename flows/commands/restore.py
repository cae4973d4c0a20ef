"""``tiltwatch restore``: an archive as a campaign with its workspace again, here or on another machine."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson
from flows.terminal import Json, answer, complain, say


def restore(
    archive: Annotated[Path, Parameter(name="ARCHIVE")],
    /,
    *,
    to: Path | None = None,
    digest: str | None = None,
    as_json: AsJson = False,
) -> int:
    """Bring back what export archive wrote: campaign file and workspace, verified, in a new folder.

    The folder appears when every file was held against its digest and the new catalog gives the answers of the old one, or
    not at all. Nothing that is there is changed.

    Parameters
    ----------
    archive
        The tar file.
    to
        New folder; named after the archive where none is named.
    digest
        Digest that was told when the archive was written; another archive is refused.
    """
    from storage.backup import restore_archive
    from storage.errors import StorageError

    source = archive.expanduser().absolute()
    if not source.is_file():
        raise StorageError(
            f"{source} is no file; name the archive that `tiltwatch export FILE archive` wrote"
        )
    folder = source.parent / source.stem if to is None else to
    restored = restore_archive(source, folder, digest)
    told = [
        f"restored {restored.folder}: {restored.n_files:,} files, each true to its digest",
        f"all {restored.views_compared} views of the catalog answer as before"
        if restored.views_compared
        else "the views of the catalog are defined anew since, so that their answers cannot be compared",
        f"digest {restored.digest}",
        f"next: tiltwatch status {restored.campaign_file}",
    ]
    if as_json:
        facts: dict[str, Json] = {
            "folder": str(restored.folder),
            "campaign_file": str(restored.campaign_file),
            "workspace": str(restored.workspace),
            "digest": restored.digest,
            "files": restored.n_files,
            "views_compared": restored.views_compared,
            "left_out": list(restored.left_out),
        }
        return answer(0, facts)
    complain(*(f"warning: when the archive was written: {left_out}" for left_out in restored.left_out))
    say(*told)
    return 0
