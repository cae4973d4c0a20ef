"""Long texts that differ little from one another, as lists of parts: what they have in common is kept once.

The settings of a campaign name all of its epochs, and every run that adds one has settings of its own: kept whole, a
thousand of them take a thousand times a thousand epochs. A text is cut where its own bytes say so, so that one epoch
more changes one or two parts, wherever it stands; the list of the parts is a text, and is cut again while it is long.
"""

import hashlib
import json
from collections.abc import Callable, MutableMapping
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np

from storage.atomic import write_our_own
from storage.digests import text_sha256
from storage.errors import StorageError

LONGEST_WHOLE: Final = 16_384
"""Bytes of the longest text that is kept as it is."""

LONGEST_LIST: Final = 4096
"""Bytes of the longest list of parts that is kept as it is: every text has one of its own."""

SHORTEST_PART: Final = 1024
"""Bytes; an accident of the bytes does not make it shorter."""

USUAL_PART: Final = 4096
"""Bytes between two places where the bytes say to cut, on an average."""

LONGEST_PART: Final = 16_384

WINDOW: Final = 256
"""So many bytes decide whether to cut behind them: enough to tell epochs apart that are alike but for their names."""

BASE: Final = 0x9E3779B97F4A7C15
"""Of the polynomial of a window; odd, so that it has an inverse."""

PARTS: Final = "settings-parts"
"""Folder of the parts of settings, beside that of the settings."""

FORM: Final = "tiltwatch text in parts, 1"

HOW_TO_READ: Final = (
    "join the files <digest>.txt beside this folder's settings in settings-parts in their order; where levels is above 1 "
    "the text is again a list of digests, a line each: join those files, and so on, levels times in all"
)

Known = MutableMapping[str, str]
"""Parts that were read before, by their digest."""


def write_text(path: Path, parts: Path, text: str) -> list[Path]:
    """Keep a text under a path, its parts in a folder where it is long; to be called under the publish lock.

    What is there as it should be is not written again.

    Returns
    -------
    list of Path
        The files that were written.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    top, levels, wanted = text, 0, {}
    while len(top.encode()) > (LONGEST_LIST if levels else LONGEST_WHOLE):
        cut = _cut(top.encode())
        digests = [hashlib.sha256(part).hexdigest() for part in cut]
        wanted.update({parts / f"{digest}.txt": part for digest, part in zip(digests, cut, strict=True)})
        top, levels = "\n".join(digests), levels + 1
    if levels:
        content = {"form": FORM, "sha256": text_sha256(text), "how_to_read": HOW_TO_READ, "levels": levels}
        top = json.dumps({**content, "parts": top.split("\n")}, indent=1) + "\n"
    wanted[path] = top.encode()  # the list after its parts
    return [place for place, content in wanted.items() if _write(place, content)]


def read_text(path: Path, parts: Path, known: Known | None = None) -> str:
    """The text that was kept under a path; its digest is for the caller to check.

    Parameters
    ----------
    known
        Parts that need not be read again; those that are read are added.

    Raises
    ------
    StorageError
        If a part is absent or damaged.
    """
    content = path.read_bytes().decode(errors="replace")
    levels, digests = _listed(content)
    if levels == 0:
        return content

    def part(digest: str) -> str:
        if known is None:
            return _part(parts, digest)
        if digest not in known:
            known[digest] = _part(parts, digest)
        return known[digest]

    text = _joined(digests, part)
    for _level in range(levels - 1):
        text = _joined(text.split("\n"), part)
    return text


def _joined(digests: list[str], part: Callable[[str], str]) -> str:
    # a letter of several bytes may be cut in two: each byte stands for itself until all are together
    return "".join(part(digest) for digest in digests).encode("latin-1").decode(errors="replace")


def _part(parts: Path, digest: str) -> str:
    path = parts / f"{digest}.txt"
    if not path.is_file():
        raise StorageError(f"{path} is absent; restore it from a backup, or run the epoch again")
    content = path.read_bytes()
    if hashlib.sha256(content).hexdigest() != digest:
        raise StorageError(
            f"{path} is damaged; delete it and restore it from a backup, or run the epoch again"
        )
    return content.decode("latin-1")


def _listed(content: str) -> tuple[int, list[str]]:
    """Levels and digests of a list of parts; none of a text that is kept as it is."""
    if FORM not in content[:100]:
        return 0, []
    try:
        told = json.loads(content)
        return int(told["levels"]), [str(digest) for digest in told["parts"]]
    except (ValueError, KeyError, TypeError):
        return 0, []  # it is damaged, which its digest tells


def _write(path: Path, content: bytes) -> bool:
    if path.is_file() and path.read_bytes() == content:
        return False
    write_our_own(path, content)
    return True


def _cut(content: bytes) -> list[bytes]:
    places, last = [0], 0
    for place in _wanted(content):
        while place - last > LONGEST_PART:
            last += LONGEST_PART
            places.append(last)
        if place - last >= SHORTEST_PART:
            last = place
            places.append(last)
    if places[-1] != len(content):
        places.append(len(content))
    return [content[start:end] for start, end in pairwise(places)]


def _wanted(content: bytes) -> list[int]:
    """Places behind which the bytes say to cut, and the end."""
    n = len(content)
    base, inverse = np.uint64(BASE), np.uint64(pow(BASE, -1, 2**64))
    powers = np.cumprod(np.full(n, base, dtype=np.uint64))
    sums = np.concatenate(
        [[np.uint64(0)], np.cumsum(np.frombuffer(content, dtype=np.uint8) * powers, dtype=np.uint64)]
    )
    # a polynomial of the bytes of the window, modulo 2**64, wherever the window stands
    windows = (sums[WINDOW:] - sums[:-WINDOW]) * np.cumprod(np.full(n, inverse, dtype=np.uint64))[
        : n + 1 - WINDOW
    ]
    # its upper bits depend on all bytes
    says_so = (
        np.flatnonzero(np.right_shift(windows * base, np.uint64(40)) % np.uint64(USUAL_PART) == 0) + WINDOW
    )
    return [*(int(place) for place in says_so), n]
