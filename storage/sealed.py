"""Contents that carry their own SHA-256 in a line before them, so that each tells by itself whether it is whole."""

import hashlib
import json
from typing import Final

HEAD_BYTES: Final = 65
"""The digest in hex, and the end of the line."""


def sealed(content: bytes) -> bytes:
    """Put the digest of a content before it."""
    return hashlib.sha256(content).hexdigest().encode() + b"\n" + content


def unsealed(stored: bytes) -> bytes | None:
    """The content behind its digest; None where the two do not belong together."""
    content = stored[HEAD_BYTES:]
    return content if sealed(content) == stored else None


def json_digest(value: object) -> str:
    """SHA-256 of plain JSON values, in whatever order their keys stand."""
    return hashlib.sha256(json.dumps(value, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def is_true_record(value: object) -> bool:
    """Whether the record of a stage has the digest that it says; one of before there were digests says none."""
    if not isinstance(value, dict) or "digest" not in value:
        return True
    content = {name: entry for name, entry in value.items() if name != "digest"}
    return bool(json_digest(content) == value["digest"])
