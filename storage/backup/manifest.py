"""What an archive says of itself, as its last member: every file with its digest, and what the catalog answered."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Final

from storage.backup.answers import Answer, Answers
from storage.errors import StorageError
from storage.store import Content

MANIFEST: Final = "manifest.json"
FORMAT: Final = 1
"""Version of the form of archives; a newer one is refused."""


@dataclass(frozen=True, slots=True)
class ArchiveManifest:
    """Files by their name in the archive, the name of the campaign file, and the answers of every view."""

    campaign: str
    schema_version: int
    files: Mapping[str, Content]
    answers: Answers
    left_out: tuple[str, ...] = ()
    """What the campaign needs and the archive does not hold, in words."""

    def to_json(self) -> bytes:
        """The manifest as it is stored: the same bytes for the same content."""
        content = {
            "tiltwatch_archive": FORMAT,
            "schema_version": self.schema_version,
            "campaign": self.campaign,
            "files": {name: asdict(content) for name, content in sorted(self.files.items())},
            "answers": asdict(self.answers),
            "left_out": list(self.left_out),
        }
        return json.dumps(content, indent=0, sort_keys=True).encode() + b"\n"

    @property
    def digest(self) -> str:
        """SHA-256 of the manifest, and thereby of everything in the archive."""
        return hashlib.sha256(self.to_json()).hexdigest()


def manifest_from(text: bytes, archive: str) -> ArchiveManifest:
    """Read a manifest.

    Raises
    ------
    StorageError
        If it is none, or of a newer form.
    """
    try:
        content = json.loads(text)
        if int(content["tiltwatch_archive"]) > FORMAT:
            raise StorageError(f"{archive} was written by a newer tiltwatch; restore it with that")
        return _manifest(content)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as fault:
        raise StorageError(
            f"{archive}: its {MANIFEST} is damaged ({type(fault).__name__}); use another copy of the archive"
        ) from fault


def _manifest(content: Mapping[str, object]) -> ArchiveManifest:
    files, answers, left_out = content["files"], content["answers"], content["left_out"]
    if not (isinstance(files, dict) and isinstance(answers, dict) and isinstance(left_out, list)):
        raise TypeError("needs tables of files and answers")
    return ArchiveManifest(
        campaign=str(content["campaign"]),
        schema_version=int(str(content["schema_version"])),
        files={str(name): Content(str(told["sha256"]), int(told["size"])) for name, told in files.items()},
        answers=Answers(
            str(answers["definitions"]),
            {str(view): Answer(int(a["rows"]), str(a["sha256"])) for view, a in answers["views"].items()},
        ),
        left_out=tuple(str(words) for words in left_out),
    )
