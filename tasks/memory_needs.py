"""What each stage needs of memory at most, from the number of points; measured, and rounded up (docs/decisions/0021)."""

from collections.abc import Iterable
from typing import Final

from tasks.memory_room import Need
from tasks.preprocessing import SEARCH_POINTS

STREAMED: Final = (".las", ".laz")
"""Formats that are read in pieces, whatever their size."""

PIECES_BYTES: Final = 150_000_000
"""Decoding in pieces, a scan."""

BYTES_OF_FILE: Final = 8
"""Reading a file of another format whole, for every byte of it: 1.5 (PLY) to 6.5 (Parquet) were measured."""

REGISTERED_POINTS: Final = 2_000_000
"""Points of a station that registration looks at; of more an even sample."""

REGISTRATION_BYTES: Final = 40
REGISTRATION_LEAST: Final = 100_000_000

SEARCH_BYTES: Final = 75
KEPT_BYTES: Final = 100
"""Isolation: for every point of the sample in which the shaft is looked for; then for every point that is kept."""

ISOLATION_LEAST: Final = 100_000_000

MORE_THAN_EXPECTED: Final = 1.05
"""How many points will be kept is known from the sample: to a few percent."""

SHAFT_BYTES: Final = 50
SHAFT_BYTES_OF_FACES: Final = 90
"""A stage on the shaft: its points and their stations, 26 bytes, and what is made of them on the way."""

SHAFT_LEAST: Final = 80_000_000

FEWER: Final = ", or lower [preprocessing] most_points"


def need_of_ingest(name: str, suffix: str, file_bytes: int) -> Need:
    """For reading a scan of that suffix (in small letters, with the dot)."""
    if suffix in STREAMED:
        return Need(PIECES_BYTES, f"reading {name}", "")
    size = PIECES_BYTES + BYTES_OF_FILE * file_bytes
    return Need(size, f"reading {name}", ", or give the scan as LAS or LAZ, which are read in pieces")


def need_of_registration(points_of_station: Iterable[int]) -> Need:
    """For the joint adjustment of stations with so many points."""
    looked_at = [min(n, REGISTERED_POINTS) for n in points_of_station]
    size = REGISTRATION_LEAST + REGISTRATION_BYTES * sum(looked_at)
    return Need(size, f"registration of {len(looked_at)} scans", "")


def need_of_isolation(n_points: int, most_points: int) -> Need:
    """For taking the shaft out of so many points."""
    searched = SEARCH_BYTES * min(n_points, SEARCH_POINTS)
    kept = round(KEPT_BYTES * min(n_points, MORE_THAN_EXPECTED * most_points))
    return Need(ISOLATION_LEAST + max(searched, kept), "isolation of the shaft", FEWER)


def need_of_shaft(n_points: int, what: str, *, by_faces: bool = False) -> Need:
    """For a stage that works on so many points of the shaft."""
    size = SHAFT_LEAST + (SHAFT_BYTES_OF_FACES if by_faces else SHAFT_BYTES) * n_points
    return Need(size, f"{what} of {n_points:,} points", FEWER)
