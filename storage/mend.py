"""Put back what is kept twice, and say in words what is lost: the first thing that a run does."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.atomic import make_folder, move_out_of_the_way, write_our_own
from storage.catalog import files_left_out, rebuild_catalog
from storage.errors import StorageError
from storage.locks import publish_lock
from storage.sealed import unsealed
from storage.seals import read_seal, sealed_epochs
from storage.second_copies import Discord, discords, keep_second, second_path
from storage.tables import SERIES_TABLES, table_path
from storage.version_manifest import MANIFEST
from storage.versions import ARCHIVE_REMEDY, archive_fault, archived_epochs
from storage.workspace import Workspace

_LOST: Final = (
    "is damaged and so is its second copy; it cannot be made again: restore it from a backup "
    "(what is left of it was renamed to {})"
)


@dataclass(frozen=True, slots=True)
class Mended:
    """What was found wrong with a file, and what became of it; ``is_lost`` where nothing can make it again."""

    where: str
    what: str
    is_lost: bool = False


def mend_copies(ws: Workspace) -> list[Mended]:
    """Put back each file that is kept twice from whichever copy is whole; set aside what is lost, so that it stops nobody.

    Files of an older tiltwatch get their second copy here, without a word.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    with publish_lock(ws):
        return [told for discord in list(discords(ws)) if (told := _mend(ws, discord)) is not None]


def losses(ws: Workspace) -> list[Mended]:
    """Results that are not whole, published and earlier ones, and that the run which ends now could not make again.

    To be asked when the catalog is rebuilt: a damaged table, with its epoch, is left out of that.
    """
    with publish_lock(ws):
        rebuild_catalog(ws)  # else what others have just published would seem to be left out
        found = [*_left_out(ws), *_missing(ws)]
    return [*found, *_earlier(ws)]


def _mend(ws: Workspace, discord: Discord) -> Mended | None:
    path = discord.path
    where = path.relative_to(ws.root).as_posix()
    match discord.state:
        case "single":
            keep_second(ws, path)
            return None
        case "second damaged":
            keep_second(ws, path)
            return Mended(where, "its second copy was damaged and is made anew")
        case "edited":
            keep_second(ws, path)
            return Mended(where, "was changed by hand since it was taken in; it counts as it stands")
        case "lost":
            left = move_out_of_the_way(path) if path.exists() else path
            second = second_path(ws, path)
            if path.name != MANIFEST and second.exists():
                move_out_of_the_way(second)  # what is left of it may be told by a person
            return Mended(where, _LOST.format(left.name), is_lost=True)
    return _put_back(ws, path, where, discord.state)


def _put_back(ws: Workspace, path: Path, where: str, state: str) -> Mended:
    if path.name == MANIFEST and not path.parent.is_dir():
        what = (
            "earlier results of an epoch are gone with their folder; they cannot be made again: restore it from a backup, "
            "unless it was moved away on purpose"
        )
        move_out_of_the_way(second_path(ws, path))  # told once
        return Mended(where, what, is_lost=True)
    content = unsealed(second_path(ws, path).read_bytes())
    if content is None:
        raise StorageError(f"{second_path(ws, path)} changed while it was read; run again")
    make_folder(path.parent)
    kept = f"; what stood there is {move_out_of_the_way(path).name}" if path.exists() else ""
    write_our_own(path, content)
    second = second_path(ws, path).relative_to(ws.root).as_posix()
    return Mended(where, f"was {state} and is put back from {second}{kept}")


def _left_out(ws: Workspace) -> Iterator[Mended]:
    for name, because in files_left_out(ws).items():
        what = (
            f"is left out of the catalog: {because}"
            if because
            else "is left out of the catalog with its epoch"
        )
        yield Mended(name, what, is_lost=True)


def _missing(ws: Workspace) -> Iterator[Mended]:
    for key in sealed_epochs(ws):
        try:
            tables = read_seal(ws, key) or {}
        except StorageError as fault:
            yield Mended(str(key), str(fault), is_lost=True)
            continue
        for table in tables:
            path = table_path(ws, table, key.structure, key.epoch)
            if table not in SERIES_TABLES and not path.exists():
                what = "was published and is gone; restore it from a backup, or run the epoch with its scans"
                yield Mended(path.relative_to(ws.root).as_posix(), what, is_lost=True)


def _earlier(ws: Workspace) -> Iterator[Mended]:
    """Earlier results that are not as they were put aside; nobody changes them, so no lock is needed."""
    for folder in archived_epochs(ws):
        fault = archive_fault(folder)
        if fault is not None:
            where = folder.relative_to(ws.root).as_posix()
            what = f"earlier results are damaged: {fault}; no run can make them again: {ARCHIVE_REMEDY}"
            yield Mended(where, what, is_lost=True)
