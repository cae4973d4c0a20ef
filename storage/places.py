"""From the words of a place to what is there: a workspace is a folder, its store that folder or s3://bucket/prefix."""

import json
import os
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Final

from storage.errors import StorageError
from storage.folder_store import FolderStore
from storage.identity import SCHEMA_VERSION
from storage.s3_store import SCHEME, VARIABLES, open_s3_store
from storage.store import Store
from storage.store_cache import FOLDER_VARIABLE, LIMIT_VARIABLE, cache_of_machine
from storage.workspace import Workspace

IDENTITY: Final = "tiltwatch-store.json"
"""Says that a bucket's prefix is a store of ours, and of which version."""


def workspace_at(place: str) -> Workspace:
    """What a stage works in: the folder at a path, or the cache of this machine before a store on S3."""
    if is_on_s3(place):
        return Workspace(cache_of_machine().root, place)
    return Workspace(Path(place))


def with_store(workspace: Workspace, place: str | None) -> Workspace:
    """Give a workspace whose artifacts and records lie at ``place``; in its own folder for None."""
    return replace(workspace, store=place)


def store_of(workspace: Workspace) -> Store:
    """The store of a workspace's artifacts and records."""
    return FolderStore(workspace.root) if workspace.store is None else store_at(workspace.store)


def store_at(place: str) -> Store:
    """Open the store at a place.

    Raises
    ------
    StorageError
        If the place or the environment does not name one.
    """
    if not is_on_s3(place):
        return FolderStore(Path(place))
    return _on_s3(
        place, tuple(os.environ.get(name) for name in (*VARIABLES, FOLDER_VARIABLE, LIMIT_VARIABLE))
    )


@lru_cache(maxsize=16)
def _on_s3(place: str, _environment: tuple[str | None, ...]) -> Store:
    """One store a place, server and user: connections are kept."""
    return open_s3_store(place, cache_of_machine())


def is_on_s3(place: str) -> bool:
    """Whether a place is on S3 and not a folder."""
    return place.startswith(SCHEME)


def check_store(place: str) -> None:
    """Make sure that a store can be read and written, and is not of a newer version.

    Raises
    ------
    StorageError
        If it is not so.
    """
    store = store_at(place)
    content = store.get(IDENTITY)
    if content is None:
        text = json.dumps({"schema_version": SCHEMA_VERSION, "made_by": "tiltwatch"})
        store.put(IDENTITY, text.encode())
        content = store.get(IDENTITY)
    version = _version(place, content or b"")
    if version > SCHEMA_VERSION:
        raise StorageError(
            f"store {place} has schema version {version}; this tiltwatch reads up to {SCHEMA_VERSION}: use a newer "
            "tiltwatch, or another prefix"
        )


def _version(place: str, content: bytes) -> int:
    try:
        return int(json.loads(content)["schema_version"])
    except (ValueError, KeyError, TypeError) as fault:
        raise StorageError(
            f"{place}/{IDENTITY} is damaged: needed is a JSON object with schema_version; restore it, or name another "
            "prefix"
        ) from fault
