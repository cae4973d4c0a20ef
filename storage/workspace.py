"""The folder that holds everything of a campaign, and its places."""

import errno
import os
from dataclasses import dataclass
from pathlib import Path

from storage.atomic import faults_of_the_system, make_folder
from storage.errors import StorageError
from storage.identity import SCHEMA_VERSION, Identity, is_identified, read_identity, write_identity
from storage.presence import check_mounted


@dataclass(frozen=True, slots=True)
class Workspace:
    """A folder that holds the artifacts, records, tables and catalog of campaigns.

    Artifacts and records of stages may lie in a store elsewhere, for workers on other machines.
    """

    root: Path
    store: str | None = None
    """Place of that store (``storage.places``); None where they lie in the folder itself."""

    @property
    def place(self) -> str:
        """Where a stage finds artifacts and records: the store, or the folder."""
        return self.store or str(self.root)

    @property
    def artifacts(self) -> Path:
        """Arrays and other results of stages, named by their digest."""
        return self.root / "artifacts"

    @property
    def records(self) -> Path:
        """Prefect's results: which artifacts belong to which cache key."""
        return self.root / "records"

    @property
    def tables(self) -> Path:
        """Parquet, one file a table, structure and epoch: the data."""
        return self.root / "tables"

    @property
    def versions(self) -> Path:
        """Tables of epochs as they were published before; kept, they cannot be made again."""
        return self.root / "versions"

    @property
    def seals(self) -> Path:
        """The digests with which epochs were published, one file each."""
        return self.root / "seals"

    @property
    def second(self) -> Path:
        """Second copies of the small files that cannot be made again."""
        return self.root / "second"

    @property
    def runs(self) -> Path:
        """What belongs to runs: the filled-in settings."""
        return self.root / "runs"

    @property
    def prefect(self) -> Path:
        """PREFECT_HOME of the runs of this workspace."""
        return self.root / "prefect"

    @property
    def locks(self) -> Path:
        """Lock files; they may be deleted when nothing runs."""
        return self.root / "locks"

    @property
    def intake(self) -> Path:
        """Epochs that were taken in from an inbox, one file each; kept, they cannot be made again."""
        return self.root / "intake"

    @property
    def previews(self) -> Path:
        """What could be told of an epoch while its stations came in."""
        return self.root / "previews"

    @property
    def tmp(self) -> Path:
        """Unfinished work and files set aside; may be deleted when nothing runs."""
        return self.root / "tmp"

    @property
    def catalog(self) -> Path:
        """The DuckDB file that people and dashboards open."""
        return self.root / "catalog.duckdb"

    @property
    def journal(self) -> Path:
        """The renames of a publication that is under way."""
        return self.root / "publish-journal.json"

    @property
    def identity(self) -> Path:
        """The file that says that this folder is a workspace, and of which version."""
        return self.root / "workspace.json"


def open_workspace(path: Path, made_by: str = "tiltwatch") -> Workspace:
    """Open a workspace, and make it if it is not there.

    Raises
    ------
    StorageError
        If the path is a file, cannot be written, is a workspace of a newer version, or the drive is missing that it
        should lie on.
    """
    workspace = Workspace(path.expanduser().resolve())
    if workspace.root.exists() and not workspace.root.is_dir():
        raise StorageError(f"workspace {workspace.root} needs a folder; it is a file: choose another path")
    if is_identified(workspace.identity):
        _check_version(workspace)
    else:
        check_mounted(workspace.root)
        write_identity(workspace.identity, Identity(SCHEMA_VERSION, made_by))
    for folder in ("artifacts", "records", "tables", "runs", "prefect", "locks", "tmp"):
        make_folder(workspace.root / folder)
        _check_writable(workspace.root / folder)
    return workspace


def _check_writable(folder: Path) -> None:
    """Refuse a folder that cannot be written: the engine says nothing of records that it could not keep."""
    with faults_of_the_system(folder):
        if hasattr(os, "statvfs") and os.statvfs(folder).f_flag & os.ST_RDONLY:
            raise OSError(errno.EROFS, os.strerror(errno.EROFS))
        if not os.access(folder, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def existing_workspace(path: Path) -> Workspace:
    """Open a workspace that must be there.

    Raises
    ------
    StorageError
        If there is none, or it is of a newer version.
    """
    workspace = Workspace(path.expanduser().resolve())
    if not is_identified(workspace.identity):
        raise StorageError(
            f"no workspace at {workspace.root}: it has no {workspace.identity.name}; process the campaign first "
            "with `tiltwatch run FILE`, or name the right folder with --workspace"
        )
    _check_version(workspace)
    return workspace


def _check_version(workspace: Workspace) -> None:
    version = read_identity(workspace.identity).schema_version
    if version > SCHEMA_VERSION:
        raise StorageError(
            f"workspace {workspace.root} has schema version {version}; this tiltwatch reads up to "
            f"{SCHEMA_VERSION}: use a newer tiltwatch, or another folder with --workspace"
        )
