"""Are the published tables those that were sealed, and is what cannot be made again there twice."""

from collections.abc import Iterator
from typing import Final

from storage.assessed import series_as_assessed
from storage.atomic import SET_ASIDE_SUFFIX
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.fault import Fault, at
from storage.seals import read_seal, seal_path, sealed_epochs
from storage.second_copies import State, discords, second_path
from storage.tables import (
    EPOCH_TABLES,
    SERIES,
    SERIES_TABLES,
    EpochKey,
    epochs_on_disk,
    files_of,
    key_of,
    table_path,
)
from storage.workspace import Workspace

_WHAT: Final[dict[State, tuple[str, str]]] = {
    "gone": ("is gone", "run the campaign again: it is put back from {}"),
    "altered": ("is damaged or was altered", "run the campaign again: it is put back from {}"),
    "edited": (
        "is not as it was taken in",
        "if it was changed by hand, run the campaign again: it counts as it stands; else copy it back from {} without the "
        "first line of that",
    ),
    "second damaged": ("is whole, its second copy {} is not", "run the campaign again: it is made anew"),
    "lost": (
        "is damaged, and there is no whole second copy",
        "restore it from a backup: it cannot be made again",
    ),
}

ANEW: Final = "run the epoch again without --only-new, or restore the file from a backup"


SERIES_ANEW: Final = "run the campaign again: the series are made anew"


def seal_faults(ws: Workspace) -> Iterator[Fault | None]:
    """Tables that are not what was published, by the seal of their epoch."""
    for key in sealed_epochs(ws):
        try:
            digests = read_seal(ws, key) or {}
        except StorageError as fault:
            yield Fault(
                at(ws, seal_path(ws, key)),
                str(fault),
                "run the epoch again without --only-new: it is made anew",
            )
            continue
        for table, digest in digests.items():
            yield _sealed_fault(ws, key, table, digest)


def series_faults(ws: Workspace) -> Iterator[Fault | None]:
    """Series that are not what the last assessment made, by the mark that it left; a next run makes them anew."""
    for structure in _assessed(ws):
        for table, digest in (series_as_assessed(ws, structure) or {}).items():
            path = table_path(ws, table, structure, SERIES)
            found = file_sha256(path) if path.is_file() else None
            what = "is gone" if found is None else "is not what was made of the epochs"
            yield None if found == digest else Fault(at(ws, path), what, SERIES_ANEW)


def unmarked_series(ws: Workspace) -> Iterator[Fault]:
    """Structures with series and no mark that tells what they were: of an older tiltwatch, or the mark is damaged."""
    for structure in _assessed(ws):
        if series_as_assessed(ws, structure) is None:
            what = "nothing tells whether its series are what was made of its epochs: their mark is absent, old or damaged"
            yield Fault(structure, what, "run the campaign again: the series and the mark are made anew")


def _assessed(ws: Workspace) -> list[str]:
    """Structures with series, and those with a mark that says so."""
    found = {key_of(path).structure for table in SERIES_TABLES for path in files_of(ws, table)}
    return sorted(found | {path.stem for path in (ws.runs / "assessed").glob("*.txt") if path.is_file()})


def unsealed_epochs(ws: Workspace) -> Iterator[Fault]:
    """Epochs of before there were seals, or whose seal is gone."""
    for key in sorted(set(epochs_on_disk(ws)) - set(sealed_epochs(ws))):
        what = "has no seal: nothing tells whether its tables are what was published (an older tiltwatch wrote none)"
        yield Fault(at(ws, seal_path(ws, key)), f"epoch {key} {what}", "run the epoch again: it is made")


def copy_faults(ws: Workspace) -> Iterator[Fault | None]:
    """Files that are kept twice and are not both whole and the same."""
    for discord in discords(ws):
        if discord.state != "single":
            second = at(ws, second_path(ws, discord.path))
            what, to_do = (text.format(second) for text in _WHAT[discord.state])
            yield Fault(at(ws, discord.path), what, to_do)
    yield None


def single_copies(ws: Workspace) -> Iterator[Fault]:
    """What is to be kept twice and is there once: of before there were second copies, or one is gone."""
    for discord in discords(ws):
        if discord.state == "single":
            second = at(ws, second_path(ws, discord.path))
            yield Fault(
                at(ws, discord.path), f"has no second copy {second}", "run the campaign again: it is made"
            )


def set_aside(ws: Workspace) -> Iterator[Fault]:
    """What was damaged and renamed, for whoever wants to look at it."""
    for folder in (ws.tables, ws.versions, ws.runs, ws.seals, ws.intake, ws.artifacts, ws.records):
        for path in sorted(folder.rglob(f"*{SET_ASIDE_SUFFIX}")):
            what = "was damaged and is set aside; nothing reads it"
            yield Fault(
                at(ws, path),
                what,
                "restore what it was from a backup where it cannot be made again, or delete it",
            )


def _sealed_fault(ws: Workspace, key: EpochKey, table: str, digest: str) -> Fault | None:
    path = table_path(ws, table, key.structure, key.epoch)
    if table not in EPOCH_TABLES:
        return None
    if not path.is_file():
        return Fault(at(ws, path), f"was published with epoch {key} and is gone", ANEW)
    if file_sha256(path) != digest:
        return Fault(
            at(ws, path),
            "is not what was published: it does not have the digest in the seal of its epoch",
            ANEW,
        )
    return None
