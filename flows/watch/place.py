"""What a watch works on: a campaign file, an inbox, a workspace, and how files are taken out of the inbox."""

from dataclasses import dataclass
from pathlib import Path

from storage.digests import file_sha256
from storage.inbox import InboxFile
from storage.s3_inbox import S3Inbox
from storage.take_over import place_copy, place_for_good, remove_placed
from storage.workspace import Workspace


@dataclass(frozen=True, slots=True)
class WatchPlace:
    """Where a watch works.

    ``inbox`` is the folder that is looked into; of an inbox on S3, the one into which its objects are fetched.
    ``keeps`` leaves the files in a folder where they are; ``moves`` moves objects on S3 that were taken in.
    """

    campaign_file: Path
    structure: str
    workspace: Workspace
    inbox: Path
    keeps: bool = False
    objects: S3Inbox | None = None
    moves: bool = False

    def place(self, file: InboxFile, target: Path, sha256: str | None = None) -> None:
        """Put a file of the inbox where it belongs; it still lies in the inbox afterwards.

        Raises
        ------
        StorageError
            If another file is there, the file changed meanwhile, or the disk refuses.
        """
        digest = sha256 or file_sha256(file.path)
        (place_copy if self.keeps else place_for_good)(file, target, digest)

    def take_out(self, file: InboxFile, target: Path) -> None:
        """Take a file out of the inbox whose copy is in its place; one that is to be kept stays.

        Raises
        ------
        StorageError
            If the copy is not whole, the file changed, or disk or store refuse.
        """
        if not self.keeps:
            remove_placed(file, target)
        if self.objects is not None and self.moves:
            self.objects.set_aside(file.name)
