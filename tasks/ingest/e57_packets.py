"""The first packet of a section of points in an E57 file (ASTM E2807, 9.3.3 and 9.3.4).

libE57Format loses two megabytes and more with every file at whose first packet it fails; what it would refuse there is
refused before it sees the file.
"""

import struct
from typing import Final

from storage.errors import InputError
from tasks.ingest.e57_pages import E57Pages, check_place, cut_short, read_content

DATA_PACKET: Final = 1
PACKET_HEAD: Final = struct.Struct("<BBHH")
PACKET_STEP: Final = 4
"""Lengths of packets are a multiple of this; so much less one may fill the end of one."""


def check_first_packet(pages: E57Pages, place: str, at: int, n_fields: int, room: int) -> None:
    """Refuse a section whose first packet, at byte ``at`` of the file, is no packet of ``n_fields`` streams.

    Parameters
    ----------
    pages, place
        The open file, and what messages call the scan.
    at, n_fields, room
        Where the packet is, how many fields a record has, and how many bytes the section leaves for packets.

    Raises
    ------
    InputError
        If it is none, or its lengths contradict each other.
    """
    check_place(pages, at, PACKET_HEAD.size, f"the first packet of {place}")
    kind, _, last, n_streams = PACKET_HEAD.unpack(read_content(pages, at, PACKET_HEAD.size))
    n_bytes, n_head = last + 1, PACKET_HEAD.size + 2 * n_streams
    if kind != DATA_PACKET or n_bytes % PACKET_STEP or n_bytes > room or n_head > n_bytes:
        raise _damaged(pages, place, f"kind {kind} with {n_bytes} bytes and {n_streams} streams")
    check_place(pages, at, n_bytes, f"the first packet of {place}")
    lengths = struct.unpack_from(f"<{n_streams}H", read_content(pages, at, n_head), PACKET_HEAD.size)
    n_needed = n_head + sum(lengths)
    if n_streams != n_fields or not n_needed <= n_bytes < n_needed + PACKET_STEP:
        raise _damaged(pages, place, f"{n_streams} streams of {n_needed} bytes in {n_bytes}")


def _damaged(pages: E57Pages, place: str, came: str) -> InputError:
    return cut_short(pages.path, f"a packet of points first in {place}", f"one of {came}")
