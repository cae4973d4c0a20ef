"""Damage to Parquet: the footer and its length, heads of pages, and whole files that no library would write."""

import random
import struct
import zlib
from collections.abc import Callable

from tests.unit.ingest.compact import footer_of, page_of, whole_file

Damage = Callable[[random.Random, bytes], bytes]


def in_footer(rng: random.Random, content: bytes) -> bytes:
    """A few bytes of the footer, where lengths, counts and offsets are packed."""
    if len(content) < 12:
        return content
    n_bytes = min(struct.unpack_from("<I", content, len(content) - 8)[0], len(content) - 12)
    damaged, start = bytearray(content), len(content) - 8 - n_bytes
    for _ in range(rng.choice((1, 1, 1, 2, 5))):
        at = rng.randrange(start, len(content) - 8) if n_bytes else 0
        damaged[at] = rng.choice(
            (damaged[at] ^ 1 << rng.randrange(8), damaged[at] ^ 0x80, 0xFF, 0x7F, 0, rng.randrange(256))
        )
    return bytes(damaged)


def footer_length(rng: random.Random, content: bytes) -> bytes:
    """Another length of the footer."""
    new = rng.choice(
        (
            0,
            1,
            len(content),
            len(content) - 8,
            len(content) - 12,
            2**31 - 1,
            2**31,
            2**32 - 1,
            rng.randrange(4000),
        )
    )
    return content[:-8] + struct.pack("<I", new) + content[-4:]


def in_page_heads(rng: random.Random, content: bytes) -> bytes:
    """Bytes near the heads of the first pages."""
    damaged = bytearray(content)
    at = 4 + rng.randrange(min(30, max(1, len(content) - 4)))
    if at < len(damaged):
        damaged[at] = rng.choice((damaged[at] ^ 1 << rng.randrange(8), 0xFF, 0x80, rng.randrange(256)))
    return bytes(damaged)


def invented(rng: random.Random, _content: bytes) -> bytes:
    """Write a file whose footer and pages contradict each other, or pages that unpack to far more than they are."""
    stated = rng.choice((8, 9, 7, 1000, 10**6, 10**8, 10**10))
    if rng.random() < 0.4:
        full = rng.choice((10**5, 10**6, 3 * 10**7))
        packer = zlib.compressobj(9, zlib.DEFLATED, 31)
        packed = packer.compress(bytes(full)) + packer.flush()
        page = page_of(rng.choice((stated, full // 8)), rng.choice((full, 64, 2**31 - 1)), packed)
        return whole_file(page, footer_of(page, n_records=rng.choice((stated, full // 8)), codec=2))
    values = struct.pack("<8d", *range(1, 9))
    page = page_of(
        rng.choice((8, stated)), rng.choice((64, 63, 0, 2**31 - 1)), values, is_dictionary=rng.random() < 0.3
    )
    footer = footer_of(
        page * rng.choice((1, 1, 2)),
        n_records=stated,
        codec=rng.choice((0, 0, 1, 2, 6, 99)),
        chunk_type=rng.choice((5, 5, 1, 4)),
    )
    return whole_file(page, footer)


IN_PARQUET: tuple[Damage, ...] = (in_footer, in_footer, in_footer, footer_length, in_page_heads, invented)
