"""Archives for tests: what is asked for, and one whose members were edited."""

import io
import tarfile
from collections.abc import Callable
from pathlib import Path

from storage.backup import ArchiveRequest, CampaignFile

Edit = Callable[[dict[str, bytes]], None]


def asked(tmp_path: Path, **more: object) -> ArchiveRequest:
    return ArchiveRequest(CampaignFile(tmp_path / "campaign.toml", "campaign.toml"), **more)  # type: ignore[arg-type]


def edited(archive: Path, edit: Edit, kinds: dict[str, bytes] | None = None) -> Path:
    """Another archive with other members; ``kinds`` names the type of those that are no plain files."""
    with tarfile.open(archive) as tar:
        members = {member.name: tar.extractfile(member).read() for member in tar}  # type: ignore[union-attr]
    edit(members)
    out = archive.with_name("edited.tar")
    with tarfile.open(out, "w") as tar:
        for name, content in members.items():
            info = tarfile.TarInfo(name)
            info.size = len(content)
            info.type = (kinds or {}).get(name, tarfile.REGTYPE)
            if info.type != tarfile.REGTYPE:
                info.size, info.linkname = 0, "/etc/passwd"
            tar.addfile(info, io.BytesIO(content))
    return out
