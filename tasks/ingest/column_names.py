"""Which columns hold the coordinates, by their names."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from storage.errors import InputError
from tasks.ingest.scan import COLUMN_NAMES, Coordinates

BRACKETS: Final = re.compile(r"[\[(]\s*([^\])]*?)\s*[\])]")
GOOD_UNITS: Final = frozenset(
    {"", "m", "metre", "meter", "metres", "meters", "deg", "degree", "degrees", "°"}
)


def find_columns(path: Path, names: Sequence[str], coordinates: Coordinates) -> tuple[int, int, int]:
    """Places of the three coordinates among the names, whatever their case and order.

    A unit may follow, as in ``x_m``, ``X [m]`` or ``alpha (deg)``.

    Raises
    ------
    InputError
        If one is missing, there twice, or in another unit.
    """
    plain = [plain_name(name) for name in names]
    first, second, third = (_place(path, names, plain, wanted) for wanted in COLUMN_NAMES[coordinates])
    return first, second, third


def plain_name(name: str) -> str:
    """Name of a column without quotes, case and unit."""
    bare = BRACKETS.sub("", name.strip().strip("\"'")).strip().lower()
    return bare.removesuffix("_m").removesuffix("_deg")


def _place(path: Path, names: Sequence[str], plain: Sequence[str], wanted: str) -> int:
    places = [index for index, name in enumerate(plain) if name == wanted]
    if len(places) != 1:
        raise InputError(
            f"{path}: needs one column {wanted!r}, came {len(places)} among "
            f"{', '.join(name.strip()[:40] for name in names[:20]) or 'no named columns'}; "
            "name the columns x, y, z, or S, alpha, omega for polar coordinates"
        )
    unit = BRACKETS.search(names[places[0]])
    if unit and unit.group(1).lower() not in GOOD_UNITS:
        raise InputError(
            f"{path}: needs metres and degrees, came column {names[places[0]].strip()!r} in {unit.group(1)}; convert it"
        )
    return places[0]
