"""Which of the scans of a file are asked for."""

from collections.abc import Sequence
from pathlib import Path

from storage.errors import InputError
from tasks.ingest.scan import ScanRequest


def choose_parts(path: Path, names: Sequence[str | None], request: ScanRequest) -> tuple[int, ...]:
    """Places, from 0, of the scans that are asked for, in the order of the file.

    Parameters
    ----------
    path : Path
        For the message.
    names : sequence of str or None
        One entry a scan of the file; None where the file states no name.
    request : ScanRequest
        ``part`` chooses by name or by number from 1; without it a frame "file" takes all, a frame "scanner" the only one.

    Raises
    ------
    InputError
        If the part does not exist, or the file holds several scans and none was chosen.
    """
    if request.part is None:
        if request.frame == "scanner" and len(names) != 1:
            raise InputError(
                f"{path}: needs one scan for a station, came {_known(names)}; "
                "write part = 1, or another of them, beside the scan in the campaign file"
            )
        return tuple(range(len(names)))
    if isinstance(request.part, int):
        if 1 <= request.part <= len(names):
            return (request.part - 1,)
    else:
        places = [place for place, name in enumerate(names) if name == request.part]
        if len(places) == 1:
            return (places[0],)
    raise InputError(f"{path}: needs part = {request.part!r}, came {_known(names)}; name one of these")


def _known(names: Sequence[str | None]) -> str:
    numbers = (
        "a file of one scan, part = 1" if len(names) == 1 else f"{len(names)} scans, part = 1 to {len(names)}"
    )
    known = ", ".join(repr(name) for name in names[:20] if name is not None)
    return numbers + (f", or by name: {known}" if known else ", without names")
