"""What goes into an archive: the campaign's files and all of the workspace that cannot be made again."""

import os
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Final

from storage.atomic import TEMP_SUFFIX
from storage.errors import StorageError, UsageError
from storage.workspace import Workspace

CAMPAIGN: Final = "campaign"
WORKSPACE: Final = "workspace"

JOURNAL: Final = "publish-journal.json"
"""Tells of a publication that did not end; an archive holds whole ones only."""

CACHE: Final = ("artifacts", "records")
"""What stages made, and which of it belongs to which question: with it nothing is computed again."""

_OF_RUNS: Final = ("runs/active", "runs/settled", "runs/assessed", "runs/code-versions.json")

MADE_AGAIN: Final = (*CACHE, *_OF_RUNS, "locks", "tmp", "prefect", "catalog.duckdb")
"""Places of a workspace that are of one machine and moment, or follow from the others; all else is the record."""


@dataclass(frozen=True, slots=True)
class CampaignFile:
    """A file of the campaign: where it lies, and its name relative to the campaign's folder, with forward slashes."""

    path: Path
    name: str


@dataclass(frozen=True, slots=True)
class ArchiveRequest:
    """What an archive is to hold beside the record of the workspace."""

    campaign: CampaignFile
    """The campaign file itself."""
    others: Sequence[CampaignFile] = ()
    """Files that it names: own limits, and the scans where they are wanted."""
    cache: bool = False
    """Whether what stages made comes along."""
    named: Collection[Path] = ()
    """Files that the campaign names: no part of the record, also where a campaign lies within its workspace."""


@dataclass(frozen=True, slots=True)
class Member:
    """A file and its name in the archive."""

    name: str
    path: Path


def campaign_members(request: ArchiveRequest) -> Iterator[Member]:
    """Files of the campaign, each once, sorted by name."""
    files = {file.name: file.path for file in (*request.others, request.campaign)}
    for name in sorted(files):
        yield Member(f"{CAMPAIGN}/{name}", files[name])


def record_members(ws: Workspace, request: ArchiveRequest) -> Iterator[Member]:
    """The record of a workspace, sorted by name; links are followed. To be asked under the publish lock.

    Raises
    ------
    StorageError
        If a link leads nowhere or in a circle.
    """
    named = {path.resolve() for path in (request.campaign.path, *request.named)}
    for member in _members(ws.root, WORKSPACE, MADE_AGAIN):
        if member.path.resolve() not in named:
            yield member


def cache_members(ws: Workspace) -> Iterator[Member]:
    """What stages made; none of it is ever changed, only added to.

    Raises
    ------
    UsageError
        If it lies in a store elsewhere.
    StorageError
        If a link leads nowhere or in a circle.
    """
    if ws.store is not None:
        raise UsageError(
            f"what stages made lies at {ws.store} and not in the workspace: copy that with the store's own tools, and "
            "write the archive without --cache"
        )
    for folder in CACHE:
        if (ws.root / folder).is_dir():
            # inodes and times of this machine
            yield from _members(ws.root / folder, f"{WORKSPACE}/{folder}", ("verified.txt",))


def is_of_the_record(name: str) -> bool:
    """Whether a file of a workspace, by its name below it, belongs into an archive: of the record or of the cache."""
    parts = PurePosixPath(name).parts
    places = {"/".join(parts[:n]) for n in range(1, len(parts) + 1)}
    return not places & (set(MADE_AGAIN) - set(CACHE)) and name != JOURNAL


def _members(top: Path, name: str, without: Collection[str]) -> Iterator[Member]:
    yield from _below(top, name, frozenset(f"{name}/{place}" for place in without), (top.resolve(),))


def _below(folder: Path, name: str, without: frozenset[str], above: tuple[Path, ...]) -> Iterator[Member]:
    """Files of a folder and of those below it; ``above`` are the folders that one came through."""
    for entry in sorted(os.scandir(folder), key=lambda entry: entry.name):
        path, member = Path(entry.path), f"{name}/{entry.name}"
        if member in without or _is_unfinished(entry.name):
            continue
        if entry.is_dir():
            place = path.resolve()
            if place in above:
                raise StorageError(
                    f"{path} is a link that leads in a circle; remove it and write the archive again"
                )
            yield from _below(path, member, without, (*above, place))
        elif entry.is_file():
            yield Member(member, path)
        elif entry.is_symlink():
            raise StorageError(
                f"{path} is a link that leads nowhere; bring back what it led to, or remove it, and write the archive again"
            )


def _is_unfinished(name: str) -> bool:
    return name.endswith((TEMP_SUFFIX, ".wal", ".lock", ".holder.json"))
