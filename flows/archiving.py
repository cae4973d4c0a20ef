"""Write the archive of a campaign, and tell what is in it and what is not."""

import sys
from dataclasses import dataclass
from pathlib import Path

from flows.terminal import answer, complain, note
from storage.backup import ArchiveRequest, CampaignFile, WrittenArchive, write_archive
from storage.backup.names import is_plain
from storage.errors import InputError, UsageError
from storage.places import with_store
from storage.workspace import Workspace
from tasks.settings import Campaign

ARCHIVE_FORMAT = "tar"


@dataclass(frozen=True, slots=True)
class ArchiveWords:
    """What the user asked for."""

    campaign_file: Path
    scans: bool
    cache: bool
    out: Path | None
    as_json: bool


def check_archive_words(file_format: str | None, chosen: str | None) -> None:
    """Refuse what makes no sense of an archive.

    Raises
    ------
    UsageError
        If another format than tar is asked for, or a part of the record.
    """
    if file_format not in (None, ARCHIVE_FORMAT):
        raise UsageError(f"an archive is a tar; --format {file_format} is for a view or geometry")
    if chosen is not None:
        raise UsageError("an archive holds the whole record: leave out --epoch, --scheme and --method")


def export_archive(place: Workspace, campaign: Campaign, words: ArchiveWords) -> int:
    """Write the archive; gives the exit code.

    Raises
    ------
    StorageError
        If something cannot be read or the file cannot be written.
    UsageError
        If what stages made is asked for and lies in a store elsewhere.
    """
    others, left_out = _files_of(campaign, scans=words.scans)
    file = words.campaign_file.expanduser().absolute()
    named = [campaign.scan_path(name) for name in _named(campaign)]
    request = ArchiveRequest(CampaignFile(file, file.name), others, words.cache, named)
    out = sys.stdout.buffer if words.out is None else words.out.expanduser().absolute()
    sys.stdout.flush()
    place = with_store(place, campaign.execution.store)
    written = write_archive(place, request, out, left_out)
    complain(*(f"warning: {told}" for told in left_out))
    return _told(written, words, left_out)


def _told(written: WrittenArchive, words: ArchiveWords, left_out: tuple[str, ...]) -> int:
    if words.as_json:
        facts = {"files": written.n_files, "bytes": written.n_bytes, "epochs": written.epochs}
        named = {"out": str(words.out), "what": "archive", "format": ARCHIVE_FORMAT, "digest": written.digest}
        return answer(0, {**named, **facts, "left_out": list(left_out)})
    note(
        f"wrote {words.out or 'the archive to stdout'}: {written.epochs} epochs, {written.n_files:,} files, "
        f"{written.n_bytes / 1e6:,.1f} MB",
        f"digest {written.digest}: keep it apart from the archive; "
        "`tiltwatch restore ARCHIVE --digest DIGEST` holds the two against each other",
    )
    return 0


def _files_of(campaign: Campaign, *, scans: bool) -> tuple[list[CampaignFile], tuple[str, ...]]:
    """Files that a campaign file names, and in words those that do not come along."""
    needed = [] if campaign.limits.file is None else [campaign.limits.file]
    named = _named(campaign)
    left_out = (
        [] if scans or not named else [f"the {len(named)} scans are not in the archive; --scans adds them"]
    )
    files = []
    for name in needed + (named if scans else []):
        try:
            file = _file_of(campaign, name)
        except InputError as why:
            left_out.append(str(why))
        else:
            files.append(file)
    return files, tuple(left_out)


def _named(campaign: Campaign) -> list[str]:
    """The scans, as the campaign names them."""
    return sorted({scan for epoch in campaign.epochs for scan in epoch.scans})


def _file_of(campaign: Campaign, name: str) -> CampaignFile:
    """A file of the campaign under its name in the archive.

    Raises
    ------
    InputError
        If it is not there, or its path would not fit another machine.
    """
    path, folder = campaign.scan_path(name), campaign.folder.resolve()
    if not path.is_file():
        raise InputError(f"{path} is not there and not in the archive")
    # by the name that the campaign file has for it: the path may lead over a link
    relative = Path(name)
    if relative.is_absolute() or ".." in relative.parts:
        if not path.is_relative_to(folder):
            raise InputError(
                f"{path} lies outside the campaign's folder and is not in the archive; save it beside and name its new "
                "place in [files] roots"
            )
        relative = path.relative_to(folder)
    if not is_plain(relative.as_posix()):
        raise InputError(
            f"{path} has a name that other systems take for another, and is not in the archive; rename it"
        )
    return CampaignFile(path, relative.as_posix())
