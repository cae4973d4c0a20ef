"""A workspace as one file: written, carried elsewhere, restored and held against its digests."""

from storage.backup.contents import ArchiveRequest, CampaignFile
from storage.backup.packing import WrittenArchive, write_archive
from storage.backup.restoring import RestoredArchive, restore_archive

__all__ = [
    "ArchiveRequest",
    "CampaignFile",
    "RestoredArchive",
    "WrittenArchive",
    "restore_archive",
    "write_archive",
]
