"""Put a received upload into the inbox: whole, under its own name, in one step."""

import os
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Final
from uuid import uuid4

from flows.upload.names import upload_name
from flows.upload.store import UploadStore
from storage.atomic import make_folder, replace_file, sync_folder
from storage.digests import file_sha256
from storage.errors import InputError

SUPERSEDED: Final = ".superseded"
"""Hidden folder of the inbox for files in whose place a new upload of the same name came."""

Received = Callable[[str, int], None]
"""Is told the name and the size in bytes of a file that came into the inbox."""


def finish_upload(store: UploadStore, inbox: Path, uid: str, received: Received) -> None:
    """Move an upload whose bytes are all there into the inbox; one that is there already is left alone.

    Raises
    ------
    InputError
        If its digest is not what its sender stated; the bytes are then set aside, and the upload is forgotten.
    StorageError
        If the disk refuses.
    """
    info = store.info(uid)
    if info is None or not store.is_received(uid):
        return
    data, metadata = store.data(uid), info["metadata"]
    name = upload_name(metadata.get("filename"))
    _check_digest(store, uid, data, metadata.get("sha256"))
    target, size_bytes = inbox / name, data.stat().st_size
    _set_aside(target, inbox)
    # the time of change is that of the arrival: what looked settled under this name before is another file
    os.utime(data)
    replace_file(data, target)
    sync_folder(inbox)
    received(name, size_bytes)


def finish_all(store: UploadStore, inbox: Path, received: Received) -> None:
    """Move uploads into the inbox that were received when the server was ended."""
    for uid in store.uids():
        if store.is_received(uid):
            finish_upload(store, inbox, uid, received)


def _check_digest(store: UploadStore, uid: str, data: Path, stated: object) -> None:
    if not isinstance(stated, str) or not stated:
        return
    sha256 = file_sha256(data)
    if sha256 != stated.strip().lower():
        data.rename(data.with_suffix(".wrong-digest"))
        store.forget(uid)
        raise InputError(f"needed the digest {stated[:12]}..., came {sha256[:12]}...; send the file again")


def _set_aside(target: Path, inbox: Path) -> None:
    """Keep the file that a new one of the same name takes the place of."""
    if not target.exists():
        return
    folder = inbox / SUPERSEDED
    make_folder(folder)
    # a clock that was set back may give a time twice, and what lies there is not to be lost
    replace_file(target, folder / f"{datetime.now(UTC):%Y%m%dT%H%M%S%fZ}-{uuid4().hex[:8]}-{target.name}")
