"""Damage to E57 under checksums that agree: the description, the heads of sections and packets, the points."""

import random
import re
import struct
from collections.abc import Callable

import numpy as np

from tasks.ingest.e57_pages import CONTENT_BYTES, HEADER_BYTES, PAGE_BYTES, checksums
from tests.faults.fuzzing.byte_damage import (
    ANYWHERE,
    clear_slice,
    flip_bits,
    put_number,
    set_byte,
    swap_slices,
)
from tests.faults.fuzzing.las_damage import put_other
from tests.faults.fuzzing.text_damage import NUMBERS

ATTRIBUTE = re.compile(
    rb'(type|minimum|maximum|scale|offset|precision|fileOffset|recordCount|length)="([^"]*)"'
)
TEXT = re.compile(rb">([-+.\deE]+)<")
ELEMENT = re.compile(rb"<([\w:]+)( [^<>]*)?(/>|>[^<>]*</\1>)")
NAMES = (
    b"cartesianX",
    b"cartesianY",
    b"cartesianZ",
    b"sphericalRange",
    b"points",
    b"prototype",
    b"data3D",
    b"pose",
    b"w",
    b"x",
)
KINDS = (
    b"Float",
    b"Integer",
    b"ScaledInteger",
    b"String",
    b"Structure",
    b"Vector",
    b"CompressedVector",
    b"Blob",
    b"",
)
HOSTILE = (
    b'<!DOCTYPE e57Root [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;">]>',
    b'<!DOCTYPE e57Root [<!ENTITY x SYSTEM "file:///etc/hostname">]>',
    b'<!DOCTYPE e57Root SYSTEM "http://127.0.0.1/x.dtd">',
    b"<?xml-stylesheet href='a'?>",
    b"<!-- a -->",
    b"&a;",
    b"&#0;",
    b"&#x41;",
    b"<![CDATA[",
    b"\xc3\x28",
    b"<a>" * 40,
    b"<a/>" * 3000,
)
ATTRIBUTES = (
    b"0",
    b"1",
    b"-1",
    b"9223372036854775807",
    b"-9223372036854775808",
    b"99999999999999999999",
    b"48",
    b"1024",
    b"1020",
)

Damage = Callable[[random.Random, bytes], bytes]


def content_of(file: bytes) -> bytes:
    """Pages without their checksums; what is no whole page is left out."""
    n_pages = len(file) // PAGE_BYTES
    pages = np.frombuffer(file[: n_pages * PAGE_BYTES], np.uint8).reshape(n_pages, PAGE_BYTES)
    return np.ascontiguousarray(pages[:, :CONTENT_BYTES]).tobytes()


def file_of(content: bytes) -> bytes:
    """Pages with checksums that agree, and a header that knows their number."""
    content += bytes(-len(content) % CONTENT_BYTES)
    pages = np.frombuffer(content, np.uint8).reshape(-1, CONTENT_BYTES)
    stored = checksums(pages).astype(">u4").view(np.uint8).reshape(-1, PAGE_BYTES - CONTENT_BYTES)
    return np.hstack([pages, stored]).tobytes()


def logical(at: int) -> int:
    """Place in the content of a place in the file."""
    return at // PAGE_BYTES * CONTENT_BYTES + min(at % PAGE_BYTES, CONTENT_BYTES)


def description(content: bytes) -> tuple[int, bytes]:
    """Where the XML begins in the content, and itself."""
    if len(content) < HEADER_BYTES:
        return 0, b""
    xml_at, n_bytes = struct.unpack_from("<QQ", content, 24)
    at = logical(xml_at)
    return at, content[at : at + n_bytes]


def with_description(content: bytes, xml: bytes) -> bytes:
    """Content with another description, behind all else; the header follows."""
    at, old = description(content)
    kept = content[:at] + bytes(len(old)) + content[at + len(old) :]
    kept = kept.rstrip(b"\0") if len(kept) > HEADER_BYTES else kept
    kept = kept.ljust(HEADER_BYTES, b"\0")
    kept += bytes(-len(kept) % 4)
    place = len(kept)
    whole = kept + xml
    n_pages = -(-len(whole) // CONTENT_BYTES)
    xml_at = place // CONTENT_BYTES * PAGE_BYTES + place % CONTENT_BYTES
    return whole[:16] + struct.pack("<QQQ", n_pages * PAGE_BYTES, xml_at, len(xml)) + whole[40:]


def _hits(xml: bytes, pattern: re.Pattern[bytes]) -> list[re.Match[bytes]]:
    return list(pattern.finditer(xml))


def _token(rng: random.Random) -> bytes:
    """A token for a number, mostly one that XML can hold."""
    token = rng.choice(NUMBERS).encode()
    return token if rng.random() < 0.1 else token.translate(None, bytes(range(32)))


def attribute(rng: random.Random, xml: bytes) -> bytes:
    """Another value of an attribute."""
    hits = _hits(xml, ATTRIBUTE)
    if not hits:
        return xml
    hit = rng.choice(hits)
    new: bytes = rng.choice(KINDS) if hit[1] == b"type" else rng.choice((*ATTRIBUTES, _token(rng)[:5000]))
    if hit[2].lstrip(b"-").isdigit() and rng.random() < 0.4:
        new = str(int(hit[2]) + rng.choice((-1, 1, 4, 1020, 1024))).encode()
    new = new.replace(b'"', b"").replace(b"\0", b"")
    return xml[: hit.start(2)] + new + xml[hit.end(2) :]


def number(rng: random.Random, xml: bytes) -> bytes:
    """Another text where a number stands."""
    hits = _hits(xml, TEXT)
    if not hits:
        return attribute(rng, xml)
    hit = rng.choice(hits)
    return xml[: hit.start(1)] + _token(rng)[:6000] + xml[hit.end(1) :]


def element(rng: random.Random, xml: bytes) -> bytes:
    """An element dropped, written twice, or under another name."""
    hits = _hits(xml, ELEMENT)
    if not hits:
        return attribute(rng, xml)
    hit = rng.choice(hits)
    new = rng.choice((b"", hit[0] * 2, hit[0].replace(hit[1], rng.choice(NAMES))))
    return xml[: hit.start()] + new + xml[hit.end() :]


def hostile(rng: random.Random, xml: bytes) -> bytes:
    """What a description has no use for."""
    at = rng.choice((xml.find(b"?>") + 2, xml.find(b"<guid"), rng.randrange(len(xml) + 1)))
    return xml[:at] + rng.choice(HOSTILE) + xml[at:]


def in_description(rng: random.Random, file: bytes) -> bytes:
    """Damage to the description, everything around made to agree."""
    content = content_of(file)
    _, xml = description(content)
    if not xml:
        return in_content(rng, file)
    for _ in range(rng.choice((1, 1, 2))):
        xml = rng.choice((attribute, attribute, attribute, number, number, element, hostile))(rng, xml)
    return file_of(with_description(content, xml))


def in_heads(rng: random.Random, file: bytes) -> bytes:
    """A lie in the header of the file, of a section, or of a packet."""
    content = content_of(file)
    section = min(HEADER_BYTES, len(content))
    places = [(8, "I"), (16, "Q"), (24, "Q"), (32, "Q"), (40, "Q")]
    places += [(section, "B"), (section + 8, "Q"), (section + 16, "Q"), (section + 24, "Q")] * 2
    packet = section + 32
    places += [
        (packet, "B"),
        (packet + 1, "B"),
        (packet + 2, "H"),
        (packet + 4, "H"),
        (packet + 6, "H"),
        (packet + 8, "H"),
    ] * 3
    at, code = rng.choice(places)
    return file_of(put_other(rng, content, at, code))


def in_content(rng: random.Random, file: bytes) -> bytes:
    """Any damage to the content, checksums made to agree."""
    content = content_of(file)
    if not content:
        return file
    damaged = rng.choice(ANYWHERE)(rng, content)
    if rng.random() < 0.8 and len(damaged) >= HEADER_BYTES:
        n_bytes = -(-len(damaged) // CONTENT_BYTES) * PAGE_BYTES
        damaged = damaged[:16] + struct.pack("<Q", n_bytes) + damaged[24:]
    return file_of(damaged)


def in_points(rng: random.Random, file: bytes) -> bytes:
    """Other numbers in the first packet, whose lengths stay."""
    content = content_of(file)
    start, end = HEADER_BYTES + 46, description(content)[0]
    if end <= start + 8:
        return in_content(rng, file)
    damaged = rng.choice((flip_bits, set_byte, put_number, swap_slices, clear_slice))(rng, content[start:end])
    return file_of(content[:start] + damaged + content[end:])


IN_E57: tuple[Damage, ...] = (
    in_description, in_description, in_description, in_heads, in_content, in_points, in_points,
)  # fmt: skip
