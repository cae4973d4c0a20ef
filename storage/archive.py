"""Put the results of many epochs aside under one name, before they are processed anew."""

from collections.abc import Sequence

from storage.locks import publish_lock
from storage.publish import recover
from storage.tables import EpochKey
from storage.versions import put_aside, version_folder
from storage.workspace import Workspace


def archive_version(
    ws: Workspace, structure: str, version: str, epochs: Sequence[str], why: str
) -> list[str]:
    """Keep the published tables of epochs under a version; an epoch that the version has is left as it is.

    Each epoch appears whole or not at all. Called again after an interruption it goes on with the epochs that lack.

    Returns
    -------
    list of str
        The epochs that were put aside by this call: not those that the version had, nor those that are not published.

    Raises
    ------
    StorageError
        If the disk refuses.
    InputError
        If an id cannot be a file name.
    """
    with publish_lock(ws):
        recover(ws)
        lacking = [name for name in epochs if not version_folder(ws, structure, version, name).exists()]
        return [
            name for name in lacking if put_aside(ws, EpochKey(structure, name), version, why) is not None
        ]
